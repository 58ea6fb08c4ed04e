// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/AssetCache.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <utility>

using namespace ist;

namespace scenes
{
namespace
{
/// File name of a tree. Two names of one mesh may give the same file, because its tree is the same.
std::string fileName(std::string name, uint64_t hash, const BuildOptions& options)
{
	for (char& c : name)
		if (c == '/' || c == '\\' || c == 0) c = '_';
	char end[80];
	std::snprintf(end, sizeof end, "-%016" PRIx64 "-%" PRId64 "-%" PRIu64 ".ist", hash, options.maxSpheres, options.seed);
	return name + end;
}

bool wasBuiltWith(const InnerSphereTree& tree, uint64_t hash, const BuildOptions& options)
{
	const InnerSphereTree::Provenance& p = tree.provenance;
	return p.meshHash == hash && p.requestedSpheres == options.maxSpheres && p.seed == options.seed && p.unit == options.unit;
}
}  // namespace

Result<CachedTree> treeFromCache(const Mesh& mesh, const BuildOptions& options, const std::string& folder, const std::string& name,
	const std::function<void(const std::string&)>& say)
{
	const auto start = std::chrono::steady_clock::now();
	const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
	const auto tell = [&](const std::string& text) {
		if (say) say(text);
	};
	const uint64_t hash = meshHash(mesh);
	const std::string path = folder.empty() ? "" : ist::utf8Path(ist::systemPath(folder) / fileName(name, hash, options));
	std::error_code ignored;
	if (!path.empty() && std::filesystem::exists(ist::systemPath(path), ignored))
	{
		Result<InnerSphereTree> loaded = loadAsset(path);
		if (loaded && wasBuiltWith(loaded.value(), hash, options))
			return CachedTree{std::make_shared<const InnerSphereTree>(std::move(loaded).value()), true, seconds()};
		tell(loaded ? path + " is of another mesh or of other settings; building it anew" : loaded.error().message + "; building it anew");
	}
	Result<InnerSphereTree> built = buildTree(mesh, options);
	if (!built) return built.error();
	if (!path.empty())
	{
		std::filesystem::create_directories(ist::systemPath(folder), ignored);
		const Result<size_t> saved = saveAsset(built.value(), path);
		if (!saved) tell(saved.error().message + "; the next run will build the tree again");
	}
	return CachedTree{std::make_shared<const InnerSphereTree>(std::move(built).value()), false, seconds()};
}
}  // namespace scenes
