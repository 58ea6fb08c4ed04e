// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeBuilder.h"

#include <functional>
#include <memory>
#include <string>

namespace scenes
{
struct CachedTree
{
	std::shared_ptr<const ist::InnerSphereTree> tree;
	bool loaded = false;  ///< from the file rather than built
	double seconds = 0;
};

/// The tree of a mesh from `folder`/NAME-HASH-SPHERES-SEED.ist (NAME with _ for slashes of both kinds and zeros), or built and left there
/// for the next time. A file that is damaged, of another version or of another mesh is built anew; why goes to `say`, as does a file that
/// cannot be written. An empty folder keeps nothing.
ist::Result<CachedTree> treeFromCache(const ist::Mesh& mesh, const ist::BuildOptions& options, const std::string& folder,
	const std::string& name, const std::function<void(const std::string&)>& say);
}  // namespace scenes
