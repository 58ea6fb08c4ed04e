// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Surface/BodySurface.h"

#include <cstdint>

namespace ist
{
/// A ball around a body.
struct BodyBall
{
	Vec3 center;
	double radius = 0;
};

/// The ball around all points of a surface. X: pose of the surface's frame in that of the ball.
inline BodyBall ballAround(const ContactSurface& surface, const Pose& X)
{
	return {X * toVec3(surface.nodes[0].center), surface.nodes[0].radius};
}

/// The part of a half-space or a box that another body can touch, as a surface of rectangles and a depth field of linear cells. Both are
/// exact. Floats stay accurate however large the half-space or the box is, because the part has a frame of its own, near the other body.
///
/// The cells meet on the medial axis: of each pair of opposite sides the nearer one counts, and the least of these three depths is that of
/// the body. A side that is nowhere the nearest has no cell. Allocates nothing.
class PlanarBody
{
public:
	PlanarBody() = default;
	PlanarBody(const PlanarBody&) = delete;
	PlanarBody& operator=(const PlanarBody&) = delete;

	/// Whether a closed form can be laid out: a valid half-space (one side) or box (six sides, in the order of BoxField), and floats
	/// resolve its depth and its thickness beside a body of this size.
	static bool canLayOut(const AnalyticField& field, const BodyBall& other);

	/// Lays out what the ball of the other body can touch, if canLayOut(). `other` is in the field's frame. Returns false if the ball
	/// touches nothing.
	bool place(const AnalyticField& field, const BodyBall& other);

	/// Valid until the next call of `place`.
	const BodySurface& body() const { return m_body; }
	/// Pose of the frame of `body` in the field's.
	const Pose& X_FB() const { return m_X_FB; }

private:
	static constexpr int kSides = 6;
	// Each of eight octants is divided among at most three sides by three planes, into four cells.
	static constexpr int kCells = 8 * 4, kPlanes = 8 * 3 + 7, kNodes = kCells + kPlanes, kQuads = 3;

	/// Points with |x + center| <= half lie between two opposite sides.
	struct Slab
	{
		double half = 0, center = 0;
	};
	/// Depth below a side: constant - sign x[axis].
	struct Side
	{
		int axis = 0;
		double sign = 1, constant = 0;
	};

	bool placeHalfSpace(const AnalyticField& field, const BodyBall& other);
	bool placeBox(const AnalyticField& field, const BodyBall& other);
	void addFace(const Side& side, Box box, const BodyBall& other);
	void divide(uint32_t node, const Box& region);
	void divideAmong(uint32_t node, const Side* sides, int count);
	uint32_t divideAt(uint32_t node, const Vec3& normal, double offset);
	void setCell(uint32_t node, const Side& side);
	PartRef tripleAt(uint32_t node);
	void fillQuads(const BodyBall& other);
	void publish(double deepest);

	BodySurface m_body;
	Pose m_X_FB;
	Box m_domain;     // of the field, in the frame of `body`
	Slab m_slabs[3];  // of a box
	int m_elementCount = 0, m_cellCount = 0, m_nodeCount = 0, m_planeCount = 0, m_quadCount = 0;
	SurfaceElement m_elements[kSides];
	DepthCell m_cells[kCells];
	DepthNode m_nodes[kNodes];
	PlaneTriple m_planes[kPlanes + 1] = {};
	SurfaceQuad m_quads[kQuads];
	PartRef m_start = 0;
};
}  // namespace ist
