// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Tools/Report.h"

#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace ist::tools
{
namespace
{
/// Version of a file that was loaded: little endian, behind the eight bytes of magic.
uint32_t storedVersion(const std::string& path)
{
	unsigned char head[12] = {};
	std::ifstream(systemPath(path), std::ios::binary).read(reinterpret_cast<char*>(head), sizeof head);
	return head[8] | head[9] << 8 | head[10] << 16 | static_cast<uint32_t>(head[11]) << 24;
}
}  // namespace

int runInfo(const InfoArguments& a)
{
	const auto start = std::chrono::steady_clock::now();
	const Result<InnerSphereTree> loaded = loadTree(a.file);
	const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	if (!loaded) return fail(loaded.error().message);
	const InnerSphereTree& tree = loaded.value();
	askAboutSize(a.file, tree.box.longestSide());
	std::error_code ignored;
	Report report = newReport();
	describeTree(report, tree, std::filesystem::file_size(systemPath(a.file), ignored));
	report["peak_memory_bytes"] = nullptr;  // memory of the build, which the asset does not record
	report["seconds_load"] = seconds;
	report["version"] = storedVersion(a.file);
	char hash[17];
	std::snprintf(hash, sizeof hash, "%016" PRIx64, tree.provenance.meshHash);
	report["mesh_hash"] = hash;
	report["unit"] = unitName(tree.provenance.unit);
	report["nodes"] = tree.law.nodes.size();
	report["center_of_mass"] = toJson(tree.origin);
	Report inertia = Report::list();
	for (const auto& row : tree.inertia.m)
		for (double v : row) inertia.append(v);
	report["inertia"] = inertia;
	report["calibration"] = Report{{"splitting_rule", 2}, {"volume_error", {kVolumeError, kVolumePower}},
		{"force_error", {kForceError, kForcePower}}, {"least_across", kLeastAcross}, {"gap", kGapError}, {"levels", tree.calibration}};
	std::fputs(format(report, a.json).c_str(), stdout);
	return kGood;
}
}  // namespace ist::tools
