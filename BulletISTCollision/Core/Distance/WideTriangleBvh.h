// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/InstructionSet.h"
#include "BulletISTCollision/Core/Distance/TriangleHierarchy.h"
#include "BulletISTCollision/Core/Distance/WideBvhNodes.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ist
{
namespace kernels
{
struct WideBvhKernel;
struct BvhSearch;
}  // namespace kernels

/// The same hierarchy eight wide, in single precision with a slack for its rounding: it rules out, and the
/// exact triangles decide, so that the answers are those of double precision.
class WideTriangleBvh
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

	WideTriangleBvh() = default;
	/// `size`: diagonal of the mesh. Keeps a reference to the hierarchy's triangles. The answers are the same with every instruction set.
	WideTriangleBvh(const TriangleHierarchy& hierarchy, double size, InstructionSet set);

	/// Nothing when nothing is nearer than the bound. `hint`: place of any triangle likely to be near; it changes the time taken, never
	/// the answer.
	Nearest nearest(const Vec3& p, double upperBound, uint32_t hint = kNone) const;
	/// Replaces `out` by the triangles within reach: distance, place in leaf order; false where there are more than `most`.
	bool within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const;

private:
	// Triangles whose planes are this much (relative, squared) beyond the best distance are still asked: rounding must not hide an equally
	// near one.
	static constexpr double kPruneSlack = 1 + 1e-13;

	struct NearestSearch;
	struct WithinSearch;

	void offer(uint32_t place, const Vec3& p, Nearest& best) const;
	uint32_t add(const TriangleHierarchy& hierarchy, const TriangleHierarchy::Child& child);
	uint32_t addLeaf(uint32_t begin, uint32_t end);
	static void setTriangle(BvhLeaf& leaf, int lane, const PreparedTriangle& t);
	static void setPlane(BvhPlanes& planes, int lane, const Vec3& normal, const Vec3& point);
	Vec3 axisOf(uint32_t begin, uint32_t end) const;
	void enclose(BvhCylinders& bound, int lane, uint32_t begin, uint32_t end) const;  ///< the triangles of these places
	void begin(kernels::BvhSearch& search, const Vec3& p) const;

	const kernels::WideBvhKernel* m_kernel = nullptr;
	const PreparedTriangle* m_triangles = nullptr;
	uint32_t m_count = 0;
	std::vector<BvhNode> m_nodes;
	std::vector<BvhLeaf> m_leaves;
	uint32_t m_root = 0;
	float m_slack = 0;  ///< more than single precision can be wrong anywhere in the mesh [m]
};
}  // namespace ist
