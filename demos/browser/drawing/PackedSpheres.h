// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "demos/browser/drawing/DrawChoice.h"
#include "demos/browser/drawing/DrawList.h"

#include <memory>
#include <set>

namespace browser
{
/// What is drawn of the packed spheres of a body. Each colouring is made when it is first seen: by level takes 0.1 s for 10,000 spheres.
/// One thread.
class PackedSpheres
{
public:
	PackedSpheres() = default;
	explicit PackedSpheres(std::shared_ptr<const ist::InnerSphereTree> tree) : m_tree(std::move(tree)) {}

	/// Adds the first `count` of them, by level or by size as is chosen; nothing where neither is.
	void draw(const DrawChoice& choice, const ist::Pose& X_WM, DrawList& list, size_t count = SIZE_MAX) const;

private:
	std::shared_ptr<const ist::InnerSphereTree> m_tree;
	mutable std::shared_ptr<const SpheresModel> m_bySize, m_byLevel;
};

/// Shades from 0 for the largest radius to 1 for the smallest, by its logarithm.
std::shared_ptr<const SpheresModel> spheresBySize(const ist::InnerSphereTree& tree);
/// Each sphere has the shade of the coarsest level at which it leads (ist::levelsOfSpheres).
std::shared_ptr<const SpheresModel> spheresByLevel(const ist::InnerSphereTree& tree);

/// Says what the colours of the list's spheres mean, and which of the levels answer now.
void addSphereKeys(const std::set<int>& answering, DrawList& list);
}  // namespace browser
