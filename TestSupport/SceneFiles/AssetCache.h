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
	bool loaded = false;  ///< true: read from the file; false: built
	double seconds = 0;
};

/// Loads the tree of a mesh from `folder`/NAME-HASH-SPHERES-SEED.ist, or builds it and stores it there. In NAME, slashes of both kinds
/// and zeros are replaced by _. A file that is damaged, of another version or of another mesh is replaced. The reason is passed to `say`,
/// as is a file that cannot be written. With an empty folder nothing is stored.
ist::Result<CachedTree> treeFromCache(const ist::Mesh& mesh, const ist::BuildOptions& options, const std::string& folder,
	const std::string& name, const std::function<void(const std::string&)>& say);
}  // namespace scenes
