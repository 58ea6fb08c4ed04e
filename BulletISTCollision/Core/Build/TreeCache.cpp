// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeCache.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Asset/Checksum.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

namespace ist
{
namespace
{
bool wasBuiltWith(const InnerSphereTree& tree, uint64_t hash, const BuildOptions& options)
{
	const InnerSphereTree::Provenance& p = tree.provenance;
	return p.meshHash == hash && p.requestedSpheres == options.maxSpheres && p.requestedFill == options.targetFill &&
		p.requestedMinRadius == options.minRadius && p.seed == options.seed && p.unit == options.unit;
}

/// Empty when the mesh has an inside.
Result<std::string> whyNoInside(const Mesh& mesh, const BuildOptions& options, double mostDoubt)
{
	if (inspect(mesh).watertight) return std::string();
	const Result<RepairedMesh> closed = repair(mesh, options.repair, options.progress);
	if (!closed) return closed.error();
	const double share = closed.value().volumeDoubt / closed.value().volumeAfter;
	if (share <= mostDoubt) return std::string();
	char text[200];
	std::snprintf(text, sizeof text,
		"the surface is open, and closing it may change its volume by %.0f %%: it has no inside that a tree could fill; "
		"close the mesh, or leave it to Bullet",
		std::fmin(share, 10) * 100);
	return std::string(text);
}

/// Empty when the tree is there now.
std::string keep(const InnerSphereTree& tree, const std::string& folder, const std::string& path)
{
	std::error_code failure;
	std::filesystem::create_directories(folder, failure);
	if (failure) return folder + ": " + failure.message();
	const Result<size_t> saved = saveAsset(tree, path);
	return saved ? std::string() : saved.error().message;
}
}  // namespace

uint64_t treeKey(const Mesh& mesh, const BuildOptions& options)
{
	const uint64_t words[] = {
		meshHash(mesh), kAssetVersion, kBuilderVersion, uint64_t(options.maxSpheres), options.seed, uint64_t(options.repair)};
	const double numbers[] = {options.targetFill, options.minRadius, options.unit, mesh.rounding};
	std::byte bytes[sizeof words + sizeof numbers];
	std::memcpy(bytes, words, sizeof words);
	std::memcpy(bytes + sizeof words, numbers, sizeof numbers);
	return checksum64(bytes, sizeof bytes);
}

Result<CachedTree> cachedTree(const Mesh& mesh, const BuildOptions& options, const std::string& folder, double mostDoubt)
{
	Result<std::string> reason = whyNoInside(mesh, options, mostDoubt);
	if (!reason) return reason.error();
	if (!reason.value().empty()) return Error{std::move(reason).value()};

	CachedTree result;
	std::string path;
	if (!folder.empty())
	{
		char name[32];
		std::snprintf(name, sizeof name, "%016" PRIx64 ".ist", treeKey(mesh, options));
		path = (std::filesystem::path(folder) / name).string();
		std::error_code ignored;
		if (std::filesystem::exists(path, ignored))
		{
			Result<InnerSphereTree> loaded = loadAsset(path);
			if (loaded && wasBuiltWith(loaded.value(), meshHash(mesh), options))
			{
				result.tree = std::make_shared<const InnerSphereTree>(std::move(loaded).value());
				result.fromCache = true;
				return result;
			}
			result.note = loaded ? path + ": of another mesh or of other settings; built anew" : loaded.error().message + "; built anew";
		}
	}
	Result<InnerSphereTree> built = buildTree(mesh, options);
	if (!built) return built.error();
	if (!path.empty())
	{
		const std::string problem = keep(built.value(), folder, path);
		if (!problem.empty()) result.note = problem;
	}
	result.tree = std::make_shared<const InnerSphereTree>(std::move(built).value());
	return result;
}
}  // namespace ist
