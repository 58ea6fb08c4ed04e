// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/DepthIntegral.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
/// Squared radius of a group of faces, of the area of all faces.
constexpr double kGroupShare = 0.001;
/// Least cosine of the angle between the normals of two faces in a group.
constexpr double kLeastCosine = 0.7;
/// Int_0^1 3 s^2 f(s) ds from f at the tip, at s = 2/3 and on the face.
constexpr double kPoint = 2.0 / 3, kAtTip = 0.025, kAtPoint = 0.675, kOnFace = 0.3;
/// Relative errors: of cones, times their number to the power 1.5; of columns, per share of the volume that they miss, and where they miss
/// none.
constexpr double kErrorOfCones = 60, kErrorOfMissing = 0.5, kErrorOfColumns = 0.03;
/// Along a crease that begins at an edge, Int depth dV grows with this power of the volume that the columns miss.
constexpr double kPower = 2.0 / 3, kMostMissed = 1e3;
/// Cones whose volume is off by more than this factor are not scaled to the exact volume.
constexpr double kMostScaling = 4;
/// Least share of the columns' energy. It keeps the energy positive.
constexpr double kLeastOfColumns = 0.1;

double depthAt(const DepthField& field, const Vec3& x)
{
	for (int axis = 0; axis < 3; ++axis)
		if (x[axis] < field.domain.lower[axis] || x[axis] > field.domain.upper[axis]) return 0;
	return std::max(0.0, field.at(x).depth);
}
}  // namespace

void DepthIntegral::begin(const Fields& fields, const Vec3& origin, double area)
{
	*this = {};
	m_origin = origin;
	m_reach = kGroupShare * area;
	m_sides[1].atOrigin = depthAt(*fields.A, origin);
	m_sides[0].atOrigin = depthAt(*fields.B, fields.X_BA * origin);
}

void DepthIntegral::add(const Fields& fields, const ContactFace& face, bool isOfB)
{
	if (!(face.area > 0)) return;
	Side& side = m_sides[isOfB];
	const double mean = face.depth / face.area;
	// The depth at the center of pressure is Int d^2 / Int d where the depth is linear.
	const double atPressure = std::clamp(mean + dot(face.gradient, face.pressureCenter - face.center), mean, 2 * mean);
	const double column = std::max(0.0, dot(face.pressure, face.gradient));
	side.columns += column;
	side.energy += 0.5 * column * atPressure;

	Group& group = side.group;
	if (group.isOpen && !belongs(group, face)) close(fields, group);
	if (!group.isOpen) group = {face.center, face.areaNormal / face.area, {}, 0, 0, true};
	const Mat3& s = face.spread;
	const double volume = (dot(face.center - m_origin, face.areaNormal) + s.m[0][0] + s.m[1][1] + s.m[2][2]) / 3;
	group.size += std::fabs(volume);
	group.moment += std::fabs(volume) * face.center;
	group.volume += volume;
	side.cones += kOnFace * volume * mean;
}

bool DepthIntegral::belongs(const Group& group, const ContactFace& face) const
{
	// Creases may lie as near as the face is deep.
	const double depth = face.depth / face.area, reach = std::min(m_reach, depth * depth);
	return squaredNorm(face.center - group.first) <= reach && dot(group.normal, face.areaNormal) > kLeastCosine * face.area;
}

void DepthIntegral::close(const Fields& fields, Group& group)
{
	group.isOpen = false;
	if (!(group.size > 0)) return;
	const Vec3 x = m_origin + kPoint * (group.moment / group.size - m_origin);
	++m_count;
	m_volume += group.volume;
	m_sides[1].cones += group.volume * (kAtPoint * depthAt(*fields.A, x) + kAtTip * m_sides[1].atOrigin);
	m_sides[0].cones += group.volume * (kAtPoint * depthAt(*fields.B, fields.X_BA * x) + kAtTip * m_sides[0].atOrigin);
}

double DepthIntegral::mixed(const Side& side, double volume) const
{
	const bool isScaled = m_volume < kMostScaling * volume && volume < kMostScaling * m_volume;
	const double cones = std::max(0.0, side.cones) * (isScaled ? volume / m_volume : 1);
	if (!(side.columns > 0) || m_count == 0) return cones;
	const double columns = side.energy * std::pow(std::min(volume / side.columns, kMostMissed), kPower);
	const double ofCones = kErrorOfCones / std::pow(double(m_count), 1.5),
				 ofColumns = kErrorOfColumns + kErrorOfMissing * std::fabs(1 - side.columns / volume);
	const double weight = ofCones * ofCones / (ofCones * ofCones + ofColumns * ofColumns);
	return std::max(weight * columns + (1 - weight) * cones, kLeastOfColumns * columns);
}

void DepthIntegral::finish(const Fields& fields, double volume)
{
	for (Side& side : m_sides)
		if (side.group.isOpen) close(fields, side.group);
	for (Side& side : m_sides) side.result = volume > 0 ? mixed(side, volume) : 0;
}
}  // namespace ist
