// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh.h"

#include <cstdint>
#include <vector>

namespace ist
{
/// The empty space of a packing: f(x) = min over triangles (unsigned distance) and placed balls (|x - c| - r).
/// An octree whose leaves list exactly the items that can be nearest to one of their points; leaves split when asked.
/// Not thread safe, not even the queries.
class DistanceOctree
{
public:
	static constexpr uint32_t noItem = UINT32_MAX;

	struct Nearest
	{
		double distance = 0;
		uint32_t item = noItem;
	};
	/// An item seen from a point x: d(x + s) >= distance + dot(gradient, s), since distances to convex sets are convex.
	struct Plane
	{
		double distance = 0;
		Vec3 gradient;
		uint32_t item = noItem;
	};

	/// `finest`: leaves are not split below this half side [m].
	DistanceOctree(const Mesh& mesh, double finest);

	/// f(x); distance -1 and no item outside the box of the mesh.
	Nearest nearest(const Vec3& x);
	/// Replaces `out` by the items of the leaf of x with distance <= f(x) + reach; returns f(x).
	Nearest gather(const Vec3& x, double reach, std::vector<Plane>& out);
	Plane plane(uint32_t item, const Vec3& x) const;
	bool isTriangle(uint32_t item) const { return item < m_triangles.size(); }

	void insert(const Vec3& center, double radius);

private:
	struct Triangle
	{
		Vec3 a, u, v;              ///< a corner and the edges from it
		Vec3 n;                    ///< unit normal; zero for a triangle without area
		Vec3 inAb, inBc, inCa;     ///< in the plane, across an edge towards the inside
	};
	struct Ball
	{
		Vec3 center;
		double radius = 0;
	};
	/// An item and its distance to the centre of the node that lists it.
	struct Entry
	{
		double distance = 0;
		uint32_t item = 0;
	};
	struct Node
	{
		Vec3 center;
		double half = 0;      ///< half side
		double nearest = 0;   ///< f(center)
		int32_t child = -1;   ///< first of eight
		int32_t unfilled = 0; ///< children that nobody has asked for yet
		bool filled = false;  ///< the entries have been taken over from the parent
		bool sorted = false;  ///< by ascending distance: leaves that have been asked
		bool covered = false; ///< wholly inside one ball, its only entry
		std::vector<Entry> entries;  ///< inner nodes keep them while a child is unfilled
	};

	/// Vector from the nearest point of the triangle to x.
	static Vec3 fromTriangle(const Triangle& t, const Vec3& x);
	double distanceTo(uint32_t item, const Vec3& x) const;
	int32_t leafOf(const Vec3& x);
	bool wantsSplit(const Node& node) const;
	void split(int32_t index);
	static void sortEntries(Node& node);
	/// A cheap sufficient test.
	bool isFartherThan(uint32_t item, const Vec3& x, double limit) const;
	void fill(Node& node, const std::vector<Entry>& candidates) const;
	void insertIntoLeaf(Node& node, const Entry& entry);
	double keepLimit(const Node& node) const;

	std::vector<Triangle> m_triangles;
	std::vector<Ball> m_hulls;  ///< bounding balls of the triangles
	std::vector<Ball> m_balls;
	std::vector<Node> m_nodes;
	double m_finest = 0;
	double m_slack = 0;  ///< absorbs rounding in the tests that drop items [m]
};
}  // namespace ist
