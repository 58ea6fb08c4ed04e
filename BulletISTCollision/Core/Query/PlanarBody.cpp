// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/PlanarBody.h"

#include "BulletISTCollision/Core/Surface/SurfaceLimits.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ist
{
namespace
{
/// Radii of the other body's ball from its center to the sides of the domain. Elements that reach beyond the domain are cut one by one, so
/// it is larger than the ball.
constexpr double kDomainRadii = 1.5;
/// Faces are larger than the ball's section by this factor, because floats round and poses are rigid only within 1e-4.
constexpr double kReach = 1.02;
/// The corners of a face lie within this many radii of the ball's center.
constexpr double kFaceRadii = 1.6;
/// Depth that a field without creases states, in radii of the ball: elements of any size are sampled.
constexpr double kDeepestRadii = 16;
/// Boxes that are thinner than this share of the ball's radius are left to the leaves: floats would not resolve them.
constexpr double kThinnest = 1e-4;

template <class T> FrozenArray<T> borrowed(const T* data, int count) { return {nullptr, data, size_t(count)}; }

void store(float (&to)[3], const Vec3& v)
{
	for (int i = 0; i < 3; ++i) to[i] = float(v[i]);
}

/// A rotation that maps z to the unit vector.
Mat3 rotationToAxis(const Vec3& z)
{
	Vec3 across;
	across[std::fabs(z.x) < std::fabs(z.y) ? (std::fabs(z.x) < std::fabs(z.z) ? 0 : 2) : (std::fabs(z.y) < std::fabs(z.z) ? 1 : 2)] = 1;
	const Vec3 x = normalized(cross(across, z)), y = cross(z, x);
	return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
}

/// Half lengths of a box in closed form.
Vec3 halfLengths(const AnalyticField& box) { return {box.side(0, {}, {}).depth, box.side(2, {}, {}).depth, box.side(4, {}, {}).depth}; }
double least(const Vec3& v) { return std::min({v.x, v.y, v.z}); }
double largest(const Vec3& v) { return std::max({v.x, v.y, v.z}); }
}  // namespace

bool PlanarBody::canLayOut(const AnalyticField& field, const BodyBall& other)
{
	if (!field.isPlanar() || !field.isValid() || !(std::fabs(field.depth(other.center)) < kFarthest)) return false;
	if (field.sideCount() == 1) return true;
	return field.sideCount() == kSides && least(halfLengths(field)) > kThinnest * other.radius;
}

bool PlanarBody::place(const AnalyticField& field, const BodyBall& other)
{
	m_elementCount = m_cellCount = m_nodeCount = m_planeCount = m_quadCount = 0;
	m_X_FB = {};
	return field.sideCount() == 1 ? placeHalfSpace(field, other) : placeBox(field, other);
}

/// The frame has its origin at the ball's center and z along the normal.
bool PlanarBody::placeHalfSpace(const AnalyticField& field, const BodyBall& other)
{
	const FieldSide plane = field.side(0, other.center, {});
	if (plane.depth < -kReach * other.radius) return false;
	m_X_FB = {rotationToAxis(normalized(plane.normal)), other.center};
	const BodyBall ball{{}, other.radius};
	const double reach = kDomainRadii * ball.radius;
	m_domain = {{-reach, -reach, -reach}, {reach, reach, reach}};
	const Side side{2, 1, plane.depth};
	addFace(side, m_domain, ball);
	m_nodeCount = 1;
	setCell(0, side);
	fillQuads(ball);
	publish(std::fabs(plane.depth) + kDeepestRadii * ball.radius);
	return true;
}

/// The frame has the axes of the box, and its origin in the middle of the domain.
bool PlanarBody::placeBox(const AnalyticField& field, const BodyBall& other)
{
	const Vec3 half = halfLengths(field);
	const double room = largest(half);
	for (int axis = 0; axis < 3; ++axis)
	{
		const double center = other.center[axis], reach = kDomainRadii * other.radius;
		if (std::fabs(center) > half[axis] + kReach * other.radius) return false;
		// Around a box that is smaller than the body, the domain leaves as much room as the box is long.
		const double lower = std::max(center - reach, -half[axis] - room), upper = std::min(center + reach, half[axis] + room);
		m_X_FB.translation[axis] = 0.5 * (lower + upper);
		m_domain.upper[axis] = 0.5 * (upper - lower);
		m_slabs[axis] = {half[axis], m_X_FB.translation[axis]};
	}
	m_domain.lower = -m_domain.upper;
	const BodyBall ball{other.center - m_X_FB.translation, other.radius};
	const Box box{-half - m_X_FB.translation, half - m_X_FB.translation};
	for (int axis = 0; axis < 3; ++axis)
		for (const double sign : {1.0, -1.0}) addFace({axis, sign, half[axis] - sign * m_slabs[axis].center}, box, ball);
	m_nodeCount = 1;
	divide(0, m_domain);
	fillQuads(ball);
	publish(m_cellCount > 1 ? least(half) : least(half) + kDeepestRadii * ball.radius);
	return true;
}

/// Adds the part of a face of `box` that the ball can touch.
void PlanarBody::addFace(const Side& side, Box box, const BodyBall& other)
{
	const double reach = kReach * other.radius, away = side.constant - side.sign * other.center[side.axis];
	const double section = std::sqrt(std::max(reach * reach - away * away, 0.0));
	Vec3 middle, half;
	for (int axis = 0; axis < 3; ++axis)
	{
		const double lower = std::max(box.lower[axis], other.center[axis] - section),
					 upper = std::min(box.upper[axis], other.center[axis] + section);
		middle[axis] = 0.5 * (lower + upper);
		half[axis] = 0.5 * (upper - lower);
	}
	const int first = (side.axis + 1) % 3, second = (side.axis + 2) % 3;
	if (!(half[first] > 0) || !(half[second] > 0)) return;
	middle[side.axis] = side.sign * side.constant;
	SurfaceElement& e = m_elements[m_elementCount++] = {};
	store(e.center, middle);
	e.e1[first] = float(half[first]);
	e.e2[second] = float(side.sign * half[second]);
	e.normal[side.axis] = float(side.sign);
	e.area = float(4 * half[first] * half[second]);
}

/// Divides a region of the box's field. Along each axis the depth below the nearer side lies between bounds that do not depend on the other
/// axes, so an axis whose least depth exceeds the largest depth of another is nowhere the nearest.
void PlanarBody::divide(uint32_t node, const Box& region)
{
	double low[3], high[3], lowest[3], bound = 1e300;  // of the depth below the nearer side, and of the least of the three
	for (int axis = 0; axis < 3; ++axis)
	{
		const auto [half, center] = m_slabs[axis];
		low[axis] = region.lower[axis] + center;
		high[axis] = region.upper[axis] + center;
		lowest[axis] = half - std::max(-low[axis], high[axis]);
		const bool holdsMiddle = low[axis] < 0 && high[axis] > 0;
		bound = std::min(bound, half - (holdsMiddle ? 0 : std::min(std::fabs(low[axis]), std::fabs(high[axis]))));
	}
	Side sides[3];
	int count = 0;
	for (int axis = 0; axis < 3; ++axis)
	{
		if (!(lowest[axis] < bound)) continue;
		const auto [half, center] = m_slabs[axis];
		if (low[axis] < 0 && high[axis] > 0)
		{
			Vec3 normal;
			normal[axis] = 1;
			const uint32_t child = divideAt(node, normal, -center);
			Box below = region, above = region;
			below.upper[axis] = above.lower[axis] = -center;
			divide(child, below);
			divide(child + 1, above);
			return;
		}
		const double sign = high[axis] > 0 ? 1 : -1;
		sides[count++] = {axis, sign, half - sign * center};
	}
	divideAmong(node, sides, count);
}

/// Divides a region among sides of different axes: where the depth below the first exceeds that below the second, the first is left out.
void PlanarBody::divideAmong(uint32_t node, const Side* sides, int count)
{
	if (count == 1) return setCell(node, sides[0]);
	const Side &a = sides[0], &b = sides[1];
	Vec3 normal;
	normal[a.axis] = -a.sign / std::numbers::sqrt2;
	normal[b.axis] = b.sign / std::numbers::sqrt2;
	const uint32_t child = divideAt(node, normal, (b.constant - a.constant) / std::numbers::sqrt2);
	const Side withFirst[2] = {a, count > 2 ? sides[2] : a}, withSecond[2] = {b, withFirst[1]};
	divideAmong(child, withFirst, count - 1);
	divideAmong(child + 1, withSecond, count - 1);
}

/// Makes a node one with a plane, and returns the first of its two children.
uint32_t PlanarBody::divideAt(uint32_t node, const Vec3& normal, double offset)
{
	DepthNode& n = m_nodes[node];
	store(n.normal, normal);
	n.offset = float(offset);
	n.child = uint32_t(m_nodeCount);
	m_nodeCount += 2;
	return n.child;
}

void PlanarBody::setCell(uint32_t node, const Side& side)
{
	m_nodes[node].child = DepthNode::kCell | uint32_t(m_cellCount);
	DepthCell& cell = m_cells[m_cellCount++] = {};
	cell.depth = float(side.constant);
	cell.gradient[side.axis] = float(-side.sign);
	cell.radius = float(m_domain.longestSide());
}

/// The part of the partition below a node. Two levels of nodes make a triple.
PartRef PlanarBody::tripleAt(uint32_t at)
{
	const DepthNode& node = m_nodes[at];
	if (node.isCell()) return ~(2 * PartRef(node.cell()));
	const auto put = [](const DepthNode& n, float(&plane)[4]) {
		for (int i = 0; i < 3; ++i) plane[i] = n.normal[i];
		plane[3] = n.offset;
	};
	const int index = ++m_planeCount;
	PlaneTriple triple{};
	put(node, triple.plane[0]);
	for (uint32_t side = 0; side < 2; ++side)
	{
		const DepthNode& child = m_nodes[node.child + side];
		if (!child.isCell()) put(child, triple.plane[1 + side]);
		for (uint32_t j = 0; j < 2; ++j) triple.child[2 * side + j] = tripleAt(child.isCell() ? node.child + side : child.child + j);
	}
	m_planes[index] = triple;
	return index;
}

/// Builds the tree of the elements: one node, or two below the root where one is too small.
void PlanarBody::fillQuads(const BodyBall& other)
{
	constexpr int kChildren = 4;
	const auto addQuad = [this]() -> SurfaceQuad& {
		SurfaceQuad& quad = m_quads[m_quadCount++] = {};
		std::fill(std::begin(quad.radius), std::end(quad.radius), -1.0f);
		return quad;
	};
	const auto setChild = [](SurfaceQuad& quad, int k, const float(&center)[3], double radius, uint32_t child) {
		quad.x[k] = center[0];
		quad.y[k] = center[1];
		quad.z[k] = center[2];
		quad.radius[k] = float(radius);
		quad.child[k] = child;
	};
	const auto setElements = [&](SurfaceQuad& quad, int first, int count) {
		for (int k = 0; k < count; ++k)
		{
			const SurfaceElement& e = m_elements[first + k];
			const double radius = std::hypot(norm(toVec3(e.e1)), norm(toVec3(e.e2))) * (1 + 1e-6);
			setChild(quad, k, e.center, radius, SurfaceNode::kElement | uint32_t(first + k));
		}
	};
	SurfaceQuad& root = addQuad();
	if (m_elementCount <= kChildren) return setElements(root, 0, m_elementCount);
	float center[3];
	store(center, other.center);
	for (int half = 0; half < 2; ++half)
	{
		const int first = half * kSides / 2, count = std::min(m_elementCount - first, kSides / 2);
		setChild(root, half, center, kFaceRadii * other.radius, uint32_t(m_quadCount));
		setElements(addQuad(), first, count);
	}
}

void PlanarBody::publish(double deepest)
{
	for (int i = 0; i < m_nodeCount; ++i) m_nodes[i].deepest = float(deepest);
	m_start = tripleAt(0);
	m_body.surface.elements = borrowed(m_elements, m_elementCount);
	m_body.field.cells = borrowed(m_cells, m_cellCount);
	m_body.field.nodes = borrowed(m_nodes, m_nodeCount);
	m_body.field.domain = m_domain;
	QueryTables& tables = m_body.tables;
	tables.quads = borrowed(m_quads, m_quadCount);
	tables.planes = borrowed(m_planes, m_planeCount + 1);
	tables.starts = borrowed(&m_start, 1);
	for (int i = 0; i < 3; ++i)
	{
		tables.lower[i] = float(m_domain.lower[i]);
		tables.voxelsPerLength[i] = float(1 / m_domain.size()[i]);
		tables.size[i] = 1;
	}
	tables.cellRadius = float(deepest);
}
}  // namespace ist
