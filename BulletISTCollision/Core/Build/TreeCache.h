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
	std::string note;  ///< reason why the folder could not be read or written, else empty; the tree is valid in any case
};

/// Hash of everything that determines the tree: the mesh, every option except threads and progress, and the versions of the builder and of
/// the asset format.
uint64_t treeKey(const Mesh& mesh, const BuildOptions& options);
/// The key as sixteen hexadecimal digits, after which the tree's file is named.
std::string treeKeyText(const Mesh& mesh, const BuildOptions& options);

/// The tree of a mesh. It is loaded from `folder`/KEY.ist if that file was built from this mesh with these options; otherwise it is
/// built and saved there. With an empty `folder` nothing is loaded or saved. A file that is damaged or belongs to something else is
/// replaced. Any number of processes may share a folder.
///
/// An open mesh is refused if closing it may change the volume by more than `mostDoubt` of it (RepairedMesh::volumeDoubt): terrain and
/// rooms are surfaces without an inside. That share is saved in `folder`/KEY.doubt beside the tree of an open mesh. So a tree in the
/// folder needs no repair of the mesh; a tree that is missing costs one repair.
Result<CachedTree> cachedTree(const Mesh& mesh, const BuildOptions& options, const std::string& folder, double mostDoubt = 0.05);
}  // namespace ist
