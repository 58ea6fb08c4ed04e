// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Geometry/EllipsoidFragment.h"
#include "BulletISTCollision/Core/Geometry/FieldTerm.h"
#include "BulletISTCollision/Core/Geometry/MomentEllipsoid.h"

namespace ist
{
/// Receives the terms of the leaves.
class FieldSink
{
public:
	virtual ~FieldSink() = default;
	virtual void take(const FieldTerm& term) = 0;
};

/// Integrates the overlap of leaves with an analytic field.
/// A leaf wider than the field's subdivision size is treated as the homogeneous box of the same moments. The box is halved until its
/// cells are small enough. Each cell is treated as the ellipsoid of its moments. It is divided among the sides by depth, as if by
/// planes, and each part is cut by its own side.
/// The result is exact for a half-space. The error is 1 to 2 % of a leaf where it was divided or an edge crosses it. Elsewhere it is of
/// third order in the ratio of size to radius of curvature, without bias.
/// The result is continuous in the pose. Allocates nothing.
class FieldClipper
{
public:
	/// X_AF: pose of the field's frame in A's tree frame.
	FieldClipper(const AnalyticField& field, const Pose& X_AF, bool stiffness, FieldSink& sink);

	/// Whether the field is a half-space. Then each leaf has one term, its exact cap, and all normals are equal.
	bool isFlat() const { return m_planar && m_sides == 1; }
	/// Returns false when a ball (in A's tree frame) is surely outside the field.
	bool mayReach(const Vec3& center, double radius) const;
	/// Sends the terms of one leaf, given in A's tree frame. `index`: number of the leaf in its terms.
	void clip(const MomentEllipsoid& leaf, uint32_t index);

private:
	/// A homogeneous parallelepiped, given by its half-axes.
	struct FieldCell
	{
		Vec3 center, half[3];
		double volume;
	};

	/// A side of a planar field, in A's tree frame. Its depth at x is offset - normal . x.
	struct Plane
	{
		Vec3 normal;
		double offset;
		double depth(const Vec3& x) const { return offset - dot(normal, x); }
	};

	bool clipByOnePlane(const MomentEllipsoid& leaf);
	FieldCell boxOf(const EllipsoidFragment& piece) const;
	bool isOutside(const EllipsoidFragment& piece) const;
	bool isOutside(const FieldCell& cell) const;
	void divide(const FieldCell& cell, int axis, int unchanged, int divisions);
	void assign(const EllipsoidFragment& piece);
	void contest(const EllipsoidFragment& piece, int winner, int challenger, int first);
	void cut(const EllipsoidFragment& piece, int index, const FieldSide& own);
	void addEdge(const FragmentCut& edge, int winner, int challenger, int first);
	void send(FieldTerm& term);

	const AnalyticField& m_field;
	const Pose& m_X;
	const Mat3 m_toField;
	const int m_sides;
	const bool m_stiffness;
	FieldSink& m_sink;
	int m_order[3] = {0, 1, 2};  // axes, ordered by subdivision size, the smallest first
	const bool m_planar;
	double m_finest = 0;                       // smallest subdivision size of a planar field [m]
	Plane m_planes[AnalyticField::kMaxSides];  // sides of a planar field
	uint32_t m_index = 0;
};
}  // namespace ist
