// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/FrozenArray.h"
#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include <cstdint>
#include <string>

namespace ist
{
/// A node of the partition of a DepthField: a plane { x : normal . x = offset }. Points with normal . x <= offset are in the first child,
/// all others in the second.
struct DepthNode
{
	float normal[3] = {};  ///< unit length
	float offset = 0;      ///< [m]
	float deepest = 0;     ///< upper bound of the depth in the node, estimated from samples [m]; a node below 0 lies outside the body
	uint32_t child = 0;    ///< index of the first child; the second follows it. With kCell set: index of the cell
	static constexpr uint32_t kCell = 0x80000000u;
	/// A node without a cell: nothing of the body is in it. It is a second child, and the first one is a cell.
	static constexpr uint32_t kOutside = 0xffffffffu;
	bool isCell() const { return (child & kCell) != 0; }
	bool isOutside() const { return child == kOutside; }
	uint32_t cell() const { return child & ~kCell; }
	/// Distance of x from the plane [m]: positive in the second child. Defined for nodes with children.
	double beyond(const Vec3& x) const { return normal[0] * x.x + normal[1] * x.y + normal[2] * x.z - offset; }
};

/// A cell of the partition: depth(x) = depth + gradient . y + y^T H y / 2 with y = x - center.
struct DepthCell
{
	float center[3] = {};    ///< mean of the cell's samples in the body and on its surface, of all if there are none [m]
	float depth = 0;         ///< [m]
	float gradient[3] = {};  ///< near unit length, pointing inwards
	float hessian[6] = {};   ///< xx, yy, zz, xy, xz, yz [1/m]
	float error = 0;         ///< root mean square of the difference from the mesh's depth over these samples [m]
	float radius = 0;        ///< root mean square distance of these samples from the center [m]

	struct Value
	{
		double depth;
		Vec3 gradient;
	};
	/// The polynomial and its gradient at x.
	Value at(const Vec3& x) const;
};

/// The depth of a body below its surface, as quadratic polynomials over a binary space partition. Depth is positive inside and negative
/// outside. Frame: that of the tree (InnerSphereTree). Outside of `domain` the body is not.
struct DepthField
{
	FrozenArray<DepthNode> nodes;  ///< the root is the first
	FrozenArray<DepthCell> cells;
	Box domain;
	double margin = 0;  ///< distance of the body's box from the sides of the domain [m]

	struct Value
	{
		double depth;
		Vec3 gradient;
		uint32_t cell;
	};
	/// The depth at x and its gradient. x must lie in the domain. In a node outside, an upper bound of the depth, and `cell` is
	/// DepthNode::kOutside. Outside of the body the depth is negative but not exact. O(log n).
	Value at(const Vec3& x) const;

	/// Empty if every invariant holds (finite values, children behind their parent, each node and cell used once); otherwise the first
	/// violation.
	std::string validate() const;
};

struct DepthFieldOptions
{
	int64_t cells = 1500;  ///< largest number of cells; a polyhedron needs fewer
	uint64_t seed = 1;
	int threads = 0;  ///< number of threads; 0: all processors
	Progress progress;
};

/// Builds the field of a closed mesh. The surface of the mesh is the zero level; what is left is `DepthCell::error`, of third order in
/// the size of a cell. Deterministic for a seed, for any number of threads. Returns an error only when cancelled.
Result<DepthField> buildDepthField(const MeshDistance& surface, const DepthFieldOptions& options);
}  // namespace ist
