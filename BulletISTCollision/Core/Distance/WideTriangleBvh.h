// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/InstructionSet.h"
#include "BulletISTCollision/Core/Distance/TriangleHierarchy.h"
#include "BulletISTCollision/Core/Distance/WideBvhNodes.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace ist
{
namespace kernels
{
struct WideBvhKernel;
struct BvhSearch;
}  // namespace kernels

/// An 8-wide version of the hierarchy in single precision, with a slack for rounding. It only excludes triangles; the remaining ones are
/// tested in double precision. So the results are those of double precision.
class WideTriangleBvh
{
public:
	static constexpr uint32_t kNone = UINT32_MAX;

	struct Nearest
	{
		Vec3 offset;  ///< from the query point
		double distance2 = 0;
		uint32_t triangle = kNone;  ///< lowest index among equally near triangles
		uint32_t place = kNone;     ///< place of the triangle in leaf order
	};

	WideTriangleBvh() = default;
	/// `size`: diagonal of the mesh. Keeps a reference to the hierarchy's triangles. Results do not depend on the instruction set. The
	/// threads of a surrounding parallel region share the work.
	WideTriangleBvh(const TriangleHierarchy& hierarchy, double size, InstructionSet set);

	/// Nearest triangle; kNone if none is nearer than the bound. `hint`: place of any triangle that is likely to be near. It changes the
	/// time taken, never the result.
	Nearest nearest(const Vec3& p, double upperBound, uint32_t hint = kNone) const;
	/// Replaces `out` by the triangles within reach (distance, place in leaf order). False if there are more than `most`.
	bool within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const;

private:
	// Triangles whose planes lie beyond the best distance by up to this factor (of squares) are still tested, so that rounding cannot
	// hide an equally near one.
	static constexpr double kPruneSlack = 1 + 1e-13;

	struct NearestSearch;
	struct WithinSearch;

	void offer(uint32_t place, const Vec3& p, Nearest& best) const;
	/// Triangles [begin, end) that a lane of a node bounds, or that a leaf holds.
	struct Range
	{
		uint32_t begin, end;
	};
	struct Layout
	{
		std::vector<std::array<Range, kBvhWidth>> lanes;  ///< of each node; empty lanes have no triangles
		std::vector<Range> leaves;
	};

	uint32_t add(const TriangleHierarchy& hierarchy, const TriangleHierarchy::Child& child, Layout& layout);
	void encloseLanes(BvhNode& node, const std::array<Range, kBvhWidth>& lanes) const;
	void fillLeaf(BvhLeaf& leaf, const Range& range) const;
	static void setTriangle(BvhLeaf& leaf, int lane, const PreparedTriangle& t);
	static void setPlane(BvhPlanes& planes, int lane, const Vec3& normal, const Vec3& point);
	Vec3 axisOf(uint32_t begin, uint32_t end) const;
	void enclose(BvhCylinders& bound, int lane, uint32_t begin, uint32_t end) const;  ///< bounds the triangles at these places
	void begin(kernels::BvhSearch& search, const Vec3& p) const;

	const kernels::WideBvhKernel* m_kernel = nullptr;
	const PreparedTriangle* m_triangles = nullptr;
	uint32_t m_count = 0;
	std::vector<BvhNode> m_nodes;
	std::unique_ptr<BvhLeaf[]> m_leaves;
	uint32_t m_root = 0;
	float m_slack = 0;  ///< more than the error of single precision anywhere in the mesh [m]
};
}  // namespace ist
