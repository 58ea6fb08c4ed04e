// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Tree/BallTree.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace bench
{
/// The inner sphere tree of the papers, for comparison: four children per node, one sphere per leaf, pointers, doubles, recursion.
class NaiveSphereTree
{
public:
	explicit NaiveSphereTree(const ist::BallTree& tree);
	~NaiveSphereTree();

	/// Lens volume, force and torque of eq. (1) about A's origin, and the work of the query.
	struct Overlap
	{
		double volume = 0;
		ist::Vec3 force, torque;
		int64_t pairs = 0, tests = 0;
	};
	/// X: transform from B's tree frame to A's.
	static Overlap query(const NaiveSphereTree& A, const NaiveSphereTree& B, const ist::Pose& X);

	struct Node
	{
		ist::Vec3 center;
		double r = 0;
		std::unique_ptr<Node> child[4];
		bool leaf() const { return !child[0]; }
	};

private:
	static std::unique_ptr<Node> build(std::vector<ist::MomentEllipsoid>& balls, size_t begin, size_t end);
	std::unique_ptr<Node> m_root;
};
}  // namespace bench
