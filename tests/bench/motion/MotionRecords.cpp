// SPDX-License-Identifier: Zlib
#include "tests/bench/motion/MotionRecords.h"

#include "demos/scenes/Pages/TextFile.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

using namespace ist;

namespace bench
{
bool MotionRecords::isDouble() { return sizeof(btScalar) == sizeof(double); }

std::string MotionRecords::pathOf(const MotionEntry& entry, const MotionSettings& settings, bool isDouble) const
{
	return m_folder + "/" + entry.name + "/" + settings.name() + (isDouble ? "-double.txt" : "-single.txt");
}

Result<MotionScene*> MotionRecords::scene(const MotionEntry& entry, int spheres)
{
	std::unique_ptr<MotionScene>& scene = m_scenes[entry.name + std::to_string(spheres)];
	if (scene) return scene.get();
	browser::DemoOptions options;
	options.spheres = spheres;
	options.cache = m_folder + "/trees";
	std::error_code failed;
	std::filesystem::create_directories(options.cache, failed);
	auto made = entry.make();
	if (const auto error = made->prepare(options)) return *error;
	scene = std::move(made);
	return scene.get();
}

std::optional<MotionRun> MotionRecords::find(const MotionEntry& entry, const MotionSettings& settings, bool isDouble) const
{
	std::ifstream file(pathOf(entry, settings, isDouble), std::ios::binary);
	if (!file) return std::nullopt;
	std::stringstream text;
	text << file.rdbuf();
	Result<MotionRun> run = runOfText(text.str());
	if (!run || run.value().checkpoints.size() != size_t(entry.seconds * kCheckpointRate + 1.5)) return std::nullopt;
	return std::move(run).value();
}

Result<MotionRun> MotionRecords::run(const MotionEntry& entry, const MotionSettings& settings)
{
	if (auto known = find(entry, settings, isDouble())) return std::move(*known);
	const Result<MotionScene*> prepared = scene(entry, settings.spheres);
	if (!prepared) return prepared.error();
	if (settings.forceError > 0 && !m_hasLevels[entry.name])
	{
		prepared.value()->addLevels();
		m_hasLevels[entry.name] = true;
	}
	Result<MotionRun> made = runMotion(*prepared.value(), entry.seconds, settings);
	if (!made) return made;
	const std::string path = pathOf(entry, settings, isDouble());
	std::error_code failed;
	std::filesystem::create_directories(std::filesystem::path(path).parent_path(), failed);
	if (!scenes::writeTextFile(path, textOf(made.value()))) return Error{"cannot write " + path};
	std::printf("  %-14s %-26s %8.2f s\n", entry.name, settings.name().c_str(), made.value().checkpoints.back().cost.seconds);
	std::fflush(stdout);
	return made;
}
}  // namespace bench
