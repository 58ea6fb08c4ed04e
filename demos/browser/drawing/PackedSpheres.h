// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "demos/browser/drawing/DrawChoice.h"
#include "demos/browser/drawing/DrawList.h"

#include <memory>
#include <set>

namespace browser
{
/// Drawing data of a body's packed spheres. Each colouring is made when it is first shown; by level this takes 0.1 s for 10,000 spheres.
/// Only one thread may use it.
class PackedSpheres
{
public:
	PackedSpheres() = default;
	explicit PackedSpheres(std::shared_ptr<const ist::InnerSphereTree> tree) : m_tree(std::move(tree)) {}

	/// Adds the first `count` spheres, coloured by level or by size as chosen; adds nothing if neither is chosen.
	void draw(const DrawChoice& choice, const ist::Pose& X_WM, DrawList& list, size_t count = SIZE_MAX) const;

private:
	std::shared_ptr<const ist::InnerSphereTree> m_tree;
	mutable std::shared_ptr<const SpheresModel> m_bySize, m_byLevel;
};

/// Shades from 0 for the largest radius to 1 for the smallest, linear in its logarithm.
std::shared_ptr<const SpheresModel> spheresBySize(const ist::InnerSphereTree& tree);
/// Each sphere has the shade of the coarsest level that it represents (ist::levelsOfSpheres).
std::shared_ptr<const SpheresModel> spheresByLevel(const ist::InnerSphereTree& tree);

/// Adds keys for the colours of the list's spheres, and for the levels that answer now.
void addSphereKeys(const std::set<int>& answering, DrawList& list);
}  // namespace browser
