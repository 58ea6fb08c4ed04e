// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/TriangleHierarchy.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ist
{
/// The same hierarchy eight wide, in single precision with a slack for its rounding: it rules out, and the
/// exact triangles decide, so that the answers are those of double precision.
class TriangleSieve
{
public:
	static constexpr uint32_t kNone = UINT32_MAX;

	struct Nearest
	{
		Vec3 offset;  ///< from the asked point
		double distance2 = 0;
		uint32_t triangle = kNone;  ///< lowest index among equally near ones
		uint32_t place = kNone;     ///< of it in leaf order
	};

	TriangleSieve() = default;
	/// `size`: diagonal of the mesh. Keeps a reference to the hierarchy's triangles.
	TriangleSieve(const TriangleHierarchy& hierarchy, double size);

	/// Nothing when nothing is nearer than the bound. `hint`: place of any triangle likely to be near; it changes the time taken, never
	/// the answer.
	Nearest nearest(const Vec3& p, double upperBound, uint32_t hint = kNone) const;
	/// Replaces `out` by the triangles within reach: distance, place in leaf order; false where there are more than `most`.
	bool within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const;

private:
	static constexpr int kWidth = 8;
	static constexpr uint32_t kLeafBit = 0x80000000u;
	// Every level leaves at most seven siblings behind.
	static constexpr int kStackSize = (kWidth - 1) * TriangleHierarchy::kMostLevels + 8;
	// Triangles whose planes are this much (relative, squared) beyond the best distance are still asked: rounding must not hide an equally near one.
	static constexpr double kPruneSlack = 1 + 1e-13;

	struct alignas(16) Planes
	{
		float x[kWidth], y[kWidth], z[kWidth], height[kWidth];  ///< unit normal, and the plane's height along it
	};
	/// Flat cylinders: each holds what a child holds. A patch of a smooth surface is much thinner than its box.
	struct alignas(16) Cylinders
	{
		float x[kWidth], y[kWidth], z[kWidth], radius[kWidth];
		Planes axis;         ///< through the middle
		float half[kWidth];  ///< of the thickness
	};
	/// Triangles, each in coordinates of its own: from the first corner along the first edge, from there towards the third corner, and
	/// along the normal.
	struct Leaf
	{
		Planes along, across, above;
		float length[3][kWidth];          ///< of the edges ab, bc, ac
		float alongEdge[2][2][kWidth];    ///< directions of bc and ac: along, across
		float unknown[kWidth];            ///< 0, or more than any square where the coordinates say nothing
		uint32_t first = 0;
	};
	struct Node
	{
		Cylinders bound;         ///< empty lanes are far away
		uint32_t child[kWidth];  ///< with kLeafBit: a leaf, else a node
		uint32_t leaves = 0;     ///< bit k set where child k is a leaf
	};
	struct Bounds;
	struct Point;
	struct NearestSearch;

	void offer(uint32_t place, const Vec3& p, Nearest& best) const;
	uint32_t add(const TriangleHierarchy& hierarchy, const TriangleHierarchy::Child& child);
	uint32_t addLeaf(uint32_t begin, uint32_t end);
	static void setTriangle(Leaf& leaf, int lane, const PreparedTriangle& t);
	static void setPlane(Planes& planes, int lane, const Vec3& normal, const Vec3& point);
	Vec3 axisOf(uint32_t begin, uint32_t end) const;
	void enclose(Cylinders& bound, int lane, uint32_t begin, uint32_t end) const;  ///< the triangles of these places

	const PreparedTriangle* m_triangles = nullptr;
	uint32_t m_count = 0;
	std::vector<Node> m_nodes;
	std::vector<Leaf> m_leaves;
	uint32_t m_root = 0;
	float m_slack = 0;  ///< more than single precision can be wrong anywhere in the mesh [m]
};

}  // namespace ist
