// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/FieldClipper.h"

#include "BulletISTCollision/Core/Base/SmoothStep.h"
#include "BulletISTCollision/Core/Geometry/Lens.h"

#include <utility>

namespace ist
{
namespace
{
// Enough divisions to halve a leaf that is 1e9 times wider than the subdivision size along all three axes.
constexpr int kMostDivisions = 90;
// Both constants keep the force from jumping when a decision changes. From the subdivision size up to kBlend times that size, a cell
// counts partly as whole and partly as halved. Sides whose depths differ by less than kTie times the mean radius of a piece are in turn
// the first to claim it.
constexpr double kBlend = 1.4, kTie = 0.2;
// A whole leaf may be this many times wider than the subdivision size. Up to there, treating it as a box would lose more accuracy than
// the division gains.
constexpr double kWholeLeaf = 1.6;
const double kWidthOfBox = std::sqrt(5.0 / 3);  // half-width of the ellipsoid with the moments of a box, over that of the box

LevelFunction depthOf(const FieldSide& s) { return {s.depth, -s.normal, s.bend * -1.0}; }

/// Function that is positive where side a is nearer than side b.
LevelFunction nearer(const FieldSide& a, const FieldSide& b) { return {b.depth - a.depth, a.normal - b.normal, a.bend + b.bend * -1.0}; }

/// Whether side a is nearer than side b everywhere in a piece. `trace`: trace of the shape of the piece. No point of the piece is
/// farther from its centre than the root of the trace. The bends add at most their trace times half of that distance squared.
bool isNearerThroughout(const FieldSide& a, const FieldSide& b, double trace)
{
	const double lead = b.depth - a.depth - 0.6 * (a.bend.trace() + b.bend.trace()) * trace;
	return lead > 0 && lead * lead > squaredNorm(a.normal - b.normal) * trace;
}
}  // namespace

// The tangent bounds each side's depth, because the depth is concave.
bool FieldClipper::mayReach(const Vec3& center, double radius) const
{
	const double reach = radius * (1 + 1e-6);
	if (m_planar)
	{
		for (int i = 0; i < m_sides; ++i)
			if (m_planes[i].depth(center) <= -reach) return false;
		return true;
	}
	const Vec3 p = m_toField * (center - m_X.translation);
	for (int i = 0; i < m_sides; ++i)
		if (m_field.side(i, p, {}).depth <= -reach) return false;
	return true;
}

FieldClipper::FieldClipper(const AnalyticField& field, const Pose& X_AF, bool stiffness, FieldSink& sink)
	: m_field(field),
	  m_X(X_AF),
	  m_toField(transpose(X_AF.rotation)),
	  m_sides(field.sideCount()),
	  m_stiffness(stiffness),
	  m_sink(sink),
	  m_planar(field.isPlanar())
{
	const Vec3 grain = field.subdivisionSize({});
	for (int i = 0; i < 3; ++i)
		for (int j = i; j > 0 && grain[m_order[j]] < grain[m_order[j - 1]]; --j) std::swap(m_order[j], m_order[j - 1]);
	m_finest = grain[m_order[0]];
	for (int i = 0; m_planar && i < m_sides; ++i)
	{
		const FieldSide plane = field.side(i, {}, {});
		const Vec3 normal = m_X.rotation * plane.normal;
		m_planes[i] = {normal, plane.depth + dot(normal, m_X.translation)};
	}
}

void FieldClipper::clip(const MomentEllipsoid& leaf, uint32_t index)
{
	m_index = index;
	if (m_planar && clipByOnePlane(leaf)) return;
	EllipsoidFragment piece{m_toField * (leaf.center() - m_X.translation), rotated(m_toField, leaf.shape()), leaf.volume()};
	const Vec3 grain = m_field.subdivisionSize(piece.center);
	const double width = std::sqrt(
		std::max({piece.shape.xx / (grain.x * grain.x), piece.shape.yy / (grain.y * grain.y), piece.shape.zz / (grain.z * grain.z)}));
	const double divided = smoothStep(std::clamp((width / kWholeLeaf - 1) / (kBlend - 1), 0.0, 1.0));
	if (divided > 0)
	{
		FieldCell cell = boxOf(piece);
		cell.volume *= divided;
		divide(cell, 0, 0, 0);
	}
	if (!(divided < 1)) return;
	piece.volume *= 1 - divided;
	if (!isOutside(piece)) assign(piece);
}

/// Does the same as `clip` for a leaf that a single plane cuts, without turning the leaf into the field's frame. Returns false for
/// other leaves.
bool FieldClipper::clipByOnePlane(const MomentEllipsoid& leaf)
{
	if (leaf.R > kWholeLeaf * m_finest) return false;
	const Vec3 center = leaf.center();
	double depth[AnalyticField::kMaxSides] = {};
	int nearest = 0;
	for (int i = 0; i < m_sides; ++i)
		if ((depth[i] = m_planes[i].depth(center)) < depth[nearest]) nearest = i;
	const Plane& plane = m_planes[nearest];
	if (depth[nearest] <= -leaf.R) return true;
	const double trace = double(leaf.xx) + leaf.yy + leaf.zz;
	for (int i = 0; i < m_sides; ++i)
	{
		const double lead = depth[i] - depth[nearest];
		if (i != nearest && lead * lead <= squaredNorm(plane.normal - m_planes[i].normal) * trace) return false;
	}
	Lens cap;
	if (!capOf(leaf, plane.normal, -depth[nearest], cap)) return true;
	FieldTerm term;
	term.ball = m_index;
	term.volume = leaf.density * cap.volume;
	term.depth = plane.depth(cap.centroid);
	term.centroid = cap.centroid;
	term.normal = plane.normal;
	term.area = plane.normal * (leaf.density * cap.area);
	m_sink.take(term);
	return true;
}

/// Box with the same moments as the piece. Its half-axes are Cholesky's columns, beginning with the axis of the smallest subdivision
/// size: halving the first column alone makes a leaf thin along that axis.
FieldClipper::FieldCell FieldClipper::boxOf(const EllipsoidFragment& piece) const
{
	FieldCell cell{piece.center, {}, piece.volume};
	SymmetricMatrix3 rest = piece.shape;
	for (int k = 0; k < 3; ++k)
	{
		const int axis = m_order[k];
		Vec3 unit;
		unit[axis] = 1;
		const Vec3 column = rest * unit;
		if (!(column[axis] > 0)) continue;
		cell.half[k] = column / (std::sqrt(column[axis]) * kWidthOfBox);
		rest += SymmetricMatrix3::square(column) * (-1 / column[axis]);
	}
	return cell;
}

bool FieldClipper::isOutside(const EllipsoidFragment& piece) const
{
	for (int i = 0; i < m_sides; ++i)
	{
		const FieldSide s = m_field.side(i, piece.center, {});
		if (s.depth <= -piece.width(s.normal)) return true;
	}
	return false;
}

bool FieldClipper::isOutside(const FieldCell& cell) const
{
	for (int i = 0; i < m_sides; ++i)
	{
		const FieldSide s = m_field.side(i, cell.center, {});
		double reach = 0;
		for (const Vec3& h : cell.half) reach += std::fabs(dot(s.normal, h));
		if (s.depth <= -kWidthOfBox * reach) return true;
	}
	return false;
}

/// Checks the half-axes in turn and halves along those that exceed the subdivision size. It ends when three checks in a row halve
/// nothing.
void FieldClipper::divide(const FieldCell& cell, int axis, int unchanged, int divisions)
{
	if (isOutside(cell)) return;
	if (unchanged == 3 || divisions == kMostDivisions)
	{
		EllipsoidFragment piece{cell.center, {}, cell.volume};
		for (const Vec3& h : cell.half) piece.shape += SymmetricMatrix3::square(h) * (5.0 / 3);
		return assign(piece);
	}
	const Vec3 grain = m_field.subdivisionSize(cell.center), &h = cell.half[axis];
	const double width = kWidthOfBox * std::max({std::fabs(h.x) / grain.x, std::fabs(h.y) / grain.y, std::fabs(h.z) / grain.z});
	const double halved = smoothStep(std::clamp((width - 1) / (kBlend - 1), 0.0, 1.0));
	const int next = (axis + 1) % 3;
	if (halved < 1)
	{
		FieldCell whole = cell;
		whole.volume *= 1 - halved;
		divide(whole, next, unchanged + 1, divisions);
	}
	if (!(halved > 0)) return;
	FieldCell half = cell;
	half.volume *= halved / 2;
	half.half[axis] *= 0.5;
	for (const double sign : {-1.0, 1.0})
	{
		half.center = cell.center + half.half[axis] * sign;
		divide(half, next, 0, divisions + 1);
	}
}

/// Cuts a piece with the sides. If several sides are about equally near to its centre, each of them is the first to claim it for a share
/// of the volume.
void FieldClipper::assign(const EllipsoidFragment& piece)
{
	const SymmetricMatrix3 spread = piece.spread();
	const double trace = piece.shape.trace(), tie = kTie * std::sqrt(trace / 3);
	FieldSide sides[AnalyticField::kMaxSides];
	double claim[AnalyticField::kMaxSides], least = INFINITY, sum = 0;
	for (int i = 0; i < m_sides; ++i) sides[i] = m_field.side(i, piece.center, spread);
	for (int i = 0; i < m_sides; ++i) least = std::min(least, sides[i].depth);
	for (int i = 0; i < m_sides; ++i)
	{
		const double t = std::max(0.0, 1 - (sides[i].depth - least) / tie);
		sum += claim[i] = t * t;
	}
	for (int i = 0; i < m_sides; ++i)
	{
		if (!(claim[i] > 0)) continue;
		EllipsoidFragment share = piece;
		share.volume *= claim[i] / sum;
		bool alone = true;
		for (int j = 0; j < m_sides && alone; ++j) alone = j == i || isNearerThroughout(sides[i], sides[j], trace);
		if (alone) cut(share, i, sides[i]);
		else contest(share, i, 0, i);
	}
}

/// Divides a piece among the sides. `winner` is the nearest side so far, compared with `first` and all sides before `challenger`.
void FieldClipper::contest(const EllipsoidFragment& piece, int winner, int challenger, int first)
{
	if (challenger == first) ++challenger;
	const SymmetricMatrix3 spread = piece.spread();
	if (challenger >= m_sides) return cut(piece, winner, m_field.side(winner, piece.center, spread));
	const FieldSide own = m_field.side(winner, piece.center, spread), other = m_field.side(challenger, piece.center, spread);
	if (isNearerThroughout(own, other, piece.shape.trace())) return contest(piece, winner, challenger + 1, first);
	const FragmentCut edge(piece, nearer(own, other));
	if (!edge.keepsNothing()) contest(edge.positive(), winner, challenger + 1, first);
	if (!edge.keepsAll()) contest(edge.negative(), challenger, challenger + 1, first);
	if (m_stiffness && edge.slope() > 0) addEdge(edge, winner, challenger, first);
}

/// Cuts a piece with one side. `own`: side `index` as seen from the centre of the piece.
void FieldClipper::cut(const EllipsoidFragment& piece, int index, const FieldSide& own)
{
	const FragmentCut surface(piece, depthOf(own));
	if (surface.keepsNothing()) return;
	const EllipsoidFragment inside = surface.positive();
	const FieldSide s = m_field.side(index, inside.center, inside.spread());
	FieldTerm term;
	term.volume = inside.volume;
	term.depth = s.depth;
	term.centroid = inside.center;
	term.normal = s.normal;
	term.area = s.normal * (piece.volume * surface.slope());
	if (m_stiffness) term.bend = s.bend * inside.volume;
	send(term);
}

/// Adds the stiffness of an edge. Where two sides are equally deep, the normal jumps from that of one side to that of the other.
void FieldClipper::addEdge(const FragmentCut& edge, int winner, int challenger, int first)
{
	const EllipsoidFragment disc = edge.disc();
	const SymmetricMatrix3 spread = disc.spread();
	const FieldSide side = m_field.side(winner, disc.center, spread);
	const Vec3 leap = side.normal - m_field.side(challenger, disc.center, spread).normal;
	double share = FragmentCut(disc, depthOf(side)).share();
	for (int other = challenger + 1; other < m_sides && share > 0; ++other)
		if (other != first) share *= FragmentCut(disc, nearer(side, m_field.side(other, disc.center, spread))).share();
	if (!(share > 0)) return;
	FieldTerm term;
	term.centroid = disc.center;
	term.bend = SymmetricMatrix3::square(leap) * (disc.volume * share);
	send(term);
}

void FieldClipper::send(FieldTerm& term)
{
	term.ball = m_index;
	term.centroid = m_X * term.centroid;
	term.normal = m_X.rotation * term.normal;
	term.area = m_X.rotation * term.area;
	if (term.bend.trace() > 0) term.bend = rotated(m_X.rotation, term.bend);
	m_sink.take(term);
}
}  // namespace ist
