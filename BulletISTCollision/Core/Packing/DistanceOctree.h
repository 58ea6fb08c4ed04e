// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/SpherePacking.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

namespace ist
{
class MeshDistance;
class ThreadPool;

/// The empty space of a packing: f(x) = min over triangles (unsigned distance) and placed balls (|x - c| - r). An octree whose leaves
/// list all items that can be nearest to one of their points. Leaves are split and nodes are filled by the first query that needs them.
/// Any number of threads may query at once; between two inserts the results do not depend on the order of queries. No query may run
/// during an insert.
class DistanceOctree
{
	struct Node;

public:
	static constexpr uint32_t kNoItem = UINT32_MAX;

	struct Nearest
	{
		double distance = 0;
		uint32_t item = kNoItem;
		const Node* leaf = nullptr;  ///< leaf that contains x, for gather()
	};
	/// An item seen from a point x: d(x + s) >= distance + dot(gradient, s), because distances to convex sets are convex.
	struct Plane
	{
		double distance = 0;
		Vec3 gradient;
		uint32_t item = kNoItem;
	};

	/// `finest`: leaves with a smaller half side are not split [m].
	DistanceOctree(const MeshDistance& surface, double finest, ThreadPool& pool);

	/// f(x); distance -1 and no item outside the box of the mesh.
	Nearest nearest(const Vec3& x);
	/// Replaces `out` by the items of the leaf of x with distance <= f(x) + reach. `at`: nearest(x), computed since the last insert.
	void gather(const Vec3& x, const Nearest& at, double reach, std::vector<Plane>& out) const;
	Plane plane(uint32_t item, const Vec3& x) const;
	bool isTriangle(uint32_t item) const { return item < m_triangles.size(); }

	/// Inserts balls. The resulting tree does not depend on the size of the thread pool.
	void insert(const std::vector<Sphere>& balls, ThreadPool& pool);

private:
	struct Triangle
	{
		Vec3 a, u, v;           ///< a corner and the edges from it
		Vec3 n;                 ///< unit normal; zero for a triangle without area
		Vec3 inAb, inBc, inCa;  ///< directions in the plane, across an edge, towards the inside
	};
	struct Ball
	{
		Vec3 center;
		double radius = 0;
	};
	/// An item and a lower bound of its distance to the centre of the node that lists it, within float precision.
	struct Entry
	{
		float distance = 0;
		uint32_t item = 0;
	};
	enum class State : uint8_t
	{
		Unfilled,  ///< no query has needed the node yet
		Filled,    ///< the entries were taken over from the parent
		Sorted     ///< sorted by ascending distance: leaves that were queried
	};
	struct Node
	{
		Vec3 center;
		double half = 0;                       ///< half side
		double nearest = 0;                    ///< f(center)
		std::atomic<Node*> children{nullptr};  ///< eight children, or null
		std::vector<Entry> entries;            ///< inner nodes keep them while a child is unfilled
		uint32_t listed = 0;                   ///< number of entries before they are released
		std::atomic<int8_t> unfilled{0};       ///< number of children that no query has needed yet
		std::atomic<State> state{State::Unfilled};
		bool covered = false;    ///< true if the node lies inside one ball, its only entry
		bool triangles = false;  ///< the entries include the triangles; false if there are too many, so that the node will be split
	};
	using Group = std::array<Node, 8>;
	struct Insertion
	{
		Node* node = nullptr;
		std::vector<uint32_t> items;
	};

	/// Vector from the nearest point of the triangle to x.
	static Vec3 fromTriangle(const Triangle& t, const Vec3& x);
	double distanceTo(uint32_t item, const Vec3& x) const;
	const Node* leafOf(const Vec3& x);
	bool isCoarse(const Node& node) const;
	bool wantsSplit(const Node& node) const;
	Node* split(Node& node);
	void sortEntries(Node& node);
	std::mutex& lockOf(const Node& node);
	/// A cheap test that is sufficient but not necessary.
	bool isFartherThan(uint32_t item, const Vec3& x, double limit) const;
	void fill(Node& child, Node& parent);
	void takeOver(Node& node, const Node& parent) const;
	void addTriangles(Node& node, double bound, std::vector<Entry>& entries) const;
	double keepLimit(const Node& node) const;

	bool admit(Node& node, uint32_t item);
	void insertBelow(Node& node, uint32_t item);
	void insertIntoLeaf(Node& node, const Entry& entry);
	void cover(Node& node, const Entry& entry);
	void recycle(Node* group);

	const MeshDistance& m_surface;
	std::vector<Triangle> m_triangles;
	std::vector<Ball> m_hulls;  ///< bounding balls of the triangles
	std::vector<Ball> m_balls;
	Node m_root;
	std::deque<Group> m_groups;
	std::vector<Node*> m_unused;  ///< groups below covered nodes
	std::mutex m_allocation;
	std::array<std::mutex, 64> m_locks;
	double m_finest = 0;
	double m_slack = 0;  ///< absorbs rounding in the tests that drop items [m]
};
}  // namespace ist
