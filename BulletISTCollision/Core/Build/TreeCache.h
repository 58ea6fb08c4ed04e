// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <memory>
#include <string>

namespace ist
{
struct CachedTree
{
	std::shared_ptr<const InnerSphereTree> tree;
	bool fromCache = false;
	std::string note;  ///< why the folder could not be read or written, when it could not: the tree is good all the same
};

/// Of all that shapes the tree: the mesh and every option but threads and progress, and the versions of the builder and of the asset
/// format.
uint64_t treeKey(const Mesh& mesh, const BuildOptions& options);

/// The tree of a mesh, from `folder`/KEY.ist when it is there and was built from this mesh with these options, else built and put
/// there. An empty `folder` is none. A file that is damaged or of something else is replaced. Any number of processes may share a folder.
///
/// Refused is a mesh that is not closed where closing it may change the volume by more than `mostDoubt` of it (RepairedMesh::volumeDoubt):
/// terrain and rooms are surfaces without an inside. That share stands in `folder`/KEY.doubt beside the tree of an open mesh, so that a
/// tree that is there needs no repair. A tree that is not there costs one.
Result<CachedTree> cachedTree(const Mesh& mesh, const BuildOptions& options, const std::string& folder, double mostDoubt = 0.05);
}  // namespace ist
