// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeCache.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Asset/Checksum.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <charconv>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

namespace ist
{
namespace
{
bool wasBuiltWith(const InnerSphereTree& tree, uint64_t hash, const BuildOptions& options)
{
	const InnerSphereTree::Provenance& p = tree.provenance;
	return p.meshHash == hash && p.requestedSpheres == options.maxSpheres && p.requestedFill == options.targetFill &&
		p.requestedMinRadius == options.minRadius && p.seed == options.seed && p.unit == options.unit &&
		tree.surface.empty() != options.surface;
}

/// Change of the volume that closing the mesh may cause, as a share of the volume.
double doubtAbout(const RepairedMesh& repaired) { return repaired.before.watertight ? 0 : repaired.volumeDoubt / repaired.volumeAfter; }

/// Reason why the mesh is refused, or an empty text when it has an inside.
std::string whyNoInside(double doubt, double mostDoubt, RepairMode mode)
{
	if (doubt <= mostDoubt) return {};
	const std::string percent = std::to_string(std::lround(std::fmin(doubt, 10) * 100)) + " %";
	if (mode == RepairMode::Ground)
		return "the ground was closed downwards, but parts of it pass through one another, and rebuilding it on a grid may change its "
			   "volume by " +
			percent + "; part them, close it deeper (GroundClosing::depth), or leave it to Bullet";
	return "the surface is open, and closing it may change its volume by " + percent +
		": it has no inside that a tree could fill; close the mesh, close it downwards if it is ground (btISTTreeSource::attachGround, "
		"BuildOptions::ground), or leave it to Bullet";
}

/// Path of the file that holds the doubt about the mesh of a tree.
std::string doubtFile(const std::string& treeFile) { return utf8Path(systemPath(treeFile).replace_extension(".doubt")); }

std::optional<double> savedDoubt(const std::string& treeFile)
{
	std::ifstream file(systemPath(doubtFile(treeFile)), std::ios::binary);
	const std::string text{std::istreambuf_iterator<char>(file), {}};
	double doubt = 0;
	const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), doubt);
	const bool isWhole = error == std::errc() && end == text.data() + text.size() && doubt >= 0;
	return isWhole ? std::optional(doubt) : std::nullopt;
}

/// Ignores a failure, because without the file the next call repairs the mesh.
void saveDoubt(double doubt, const std::string& treeFile)
{
	char text[40];
	const char* const end = std::to_chars(text, text + sizeof text, doubt).ptr;
	static_cast<void>(writeFileAtomically(doubtFile(treeFile), reinterpret_cast<const std::byte*>(text), size_t(end - text)));
}

/// Doubt about the mesh of a tree that was loaded. If the file is missing, as in folders of older versions, the mesh is repaired once.
Result<double> doubtBehind(const InnerSphereTree& tree, const std::string& treeFile, const Mesh& mesh, const BuildOptions& options)
{
	if (tree.provenance.watertight) return 0.0;
	if (const std::optional<double> saved = savedDoubt(treeFile)) return *saved;
	const Result<RepairedMesh> repaired = repairToBuild(mesh, options);
	if (!repaired) return repaired.error();
	const double doubt = doubtAbout(repaired.value());
	saveDoubt(doubt, treeFile);
	return doubt;
}

/// Saves the tree. Returns an empty text on success, else the reason.
std::string keep(const InnerSphereTree& tree, double doubt, const std::string& folder, const std::string& path)
{
	std::error_code failure;
	std::filesystem::create_directories(systemPath(folder), failure);
	if (failure) return folder + ": " + failure.message();
	if (!tree.provenance.watertight) saveDoubt(doubt, path);
	const Result<size_t> saved = saveAsset(tree, path);
	return saved ? std::string() : saved.error().message;
}
}  // namespace

uint64_t treeKey(const Mesh& mesh, const BuildOptions& options)
{
	const uint64_t words[] = {meshHash(mesh), kAssetVersion, kBuilderVersion, uint64_t(options.maxSpheres), options.seed,
		uint64_t(options.repair), uint64_t(options.surface)};
	const double numbers[] = {options.targetFill, options.minRadius, options.unit, mesh.rounding};
	const std::string ground = options.repair == RepairMode::Ground ? groundText(options.ground) : "";
	std::string bytes(sizeof words + sizeof numbers, '\0');
	std::memcpy(bytes.data(), words, sizeof words);
	std::memcpy(bytes.data() + sizeof words, numbers, sizeof numbers);
	bytes += ground;
	return checksum64(reinterpret_cast<const std::byte*>(bytes.data()), bytes.size());
}

std::string treeKeyText(const Mesh& mesh, const BuildOptions& options)
{
	char text[32];
	std::snprintf(text, sizeof text, "%016" PRIx64, treeKey(mesh, options));
	return text;
}

Result<CachedTree> cachedTree(const Mesh& mesh, const BuildOptions& options, const std::string& folder, double mostDoubt)
{
	CachedTree result;
	std::string path;
	if (!folder.empty())
	{
		path = utf8Path(systemPath(folder) / (treeKeyText(mesh, options) + ".ist"));
		std::error_code ignored;
		if (std::filesystem::exists(systemPath(path), ignored))
		{
			Result<InnerSphereTree> loaded = loadAsset(path);
			if (loaded && wasBuiltWith(loaded.value(), meshHash(mesh), options))
			{
				const Result<double> doubt = doubtBehind(loaded.value(), path, mesh, options);
				if (!doubt) return doubt.error();
				if (const std::string reason = whyNoInside(doubt.value(), mostDoubt, options.repair); !reason.empty()) return Error{reason};
				result.tree = std::make_shared<const InnerSphereTree>(std::move(loaded).value());
				result.fromCache = true;
				return result;
			}
			result.note = loaded ? path + ": of another mesh or of other settings; built anew" : loaded.error().message + "; built anew";
		}
	}
	const Result<RepairedMesh> repaired = repairToBuild(mesh, options);
	if (!repaired) return repaired.error();
	const double doubt = doubtAbout(repaired.value());
	if (const std::string reason = whyNoInside(doubt, mostDoubt, options.repair); !reason.empty()) return Error{reason};
	Result<InnerSphereTree> built = buildRepaired(mesh, repaired.value(), options);
	if (!built) return built.error();
	if (!path.empty())
	{
		const std::string problem = keep(built.value(), doubt, folder, path);
		if (!problem.empty()) result.note = problem;
	}
	result.tree = std::make_shared<const InnerSphereTree>(std::move(built).value());
	return result;
}
}  // namespace ist
