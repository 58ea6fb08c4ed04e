// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/DepthIntegral.h"

#include "BulletISTCollision/Core/Query/Kernels/QueryKernel.h"

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
/// Cones have no weight while the columns miss a smaller share of the volume than the first, and all of theirs from the second on.
constexpr double kNoCones = 0.04, kAllCones = 0.08;
/// Least share of the columns' energy. It keeps the energy positive.
constexpr double kLeastOfColumns = 0.1;

/// Share of the volume that the columns miss, or have in excess.
double missedShare(double columns, double volume) { return std::fabs(1 - columns / volume); }
}  // namespace

ConePoints::ConePoints(size_t most)
	: m_numbers((most + kernels::kListSlack) * 2 * kColumns),
	  m_weight(most),
	  m_part(most),
	  m_stride(most + kernels::kListSlack)
{}

void ConePoints::makeResident()
{
	m_numbers.touch();
	m_weight.touch();
	m_part.touch();
}

size_t ConePoints::add(const Vec3& point, double weight, uint32_t part)
{
	const Vec3 places[2] = {point, m_X_BA * point};
	for (int body = 0; body < 2; ++body)
		for (int i = 0; i < 3; ++i) column(body, i)[m_count] = float(places[body][i]);
	m_weight[m_count] = weight;
	m_part[m_count] = part;
	return m_count++;
}

void ConePoints::sample(const BodySurface& A, const BodySurface& B, const kernels::QueryKernel& kernel)
{
	const BodySurface* bodies[2] = {&A, &B};
	for (int body = 0; body < 2; ++body)
		kernel.sampleDepths(
			fieldTablesOf(*bodies[body]), {column(body, 0), column(body, 1), column(body, 2), column(body, 3), int(m_count)});
}

void DepthIntegral::addColumn(const ContactFace& face, bool isOfB)
{
	if (!(face.area > 0)) return;
	Side& side = m_sides[isOfB];
	const double mean = face.depth / face.area;
	// The depth at the center of pressure is Int d^2 / Int d where the depth is linear.
	const double atPressure = std::clamp(mean + dot(face.gradient, face.pressureCenter - face.center), mean, 2 * mean);
	const double column = dot(face.pressure, face.gradient);
	side.columns += column;
	side.energy += 0.5 * column * atPressure;
}

bool DepthIntegral::needsCones(double volume) const
{
	const auto misses = [&](const Side& side) { return missedShare(side.columns, volume) > kNoCones; };
	return volume > 0 && (misses(m_sides[0]) || misses(m_sides[1]));
}

void DepthIntegral::beginCones(const Vec3& origin, double area, uint32_t part, ConePoints& points)
{
	m_origin = origin;
	m_reach = kGroupShare * area;
	m_part = part;
	m_tip = points.add(origin, 0, part);
}

void DepthIntegral::addCone(const ContactFace& face, bool isOfB, ConePoints& points)
{
	if (!(face.area > 0)) return;
	Side& side = m_sides[isOfB];
	Group& group = side.group;
	if (group.isOpen && !belongs(group, face)) close(group, points);
	if (!group.isOpen) group = {face.center, face.areaNormal / face.area, {}, 0, 0, true};
	const Mat3& s = face.spread;
	const double volume = (dot(face.center - m_origin, face.areaNormal) + s.m[0][0] + s.m[1][1] + s.m[2][2]) / 3;
	group.size += std::fabs(volume);
	group.moment += std::fabs(volume) * face.center;
	group.volume += volume;
	side.cones += kOnFace * volume * face.depth / face.area;
}

bool DepthIntegral::belongs(const Group& group, const ContactFace& face) const
{
	// Creases may lie as near as the face is deep.
	const double depth = face.depth / face.area, reach = std::min(m_reach, depth * depth);
	return squaredNorm(face.center - group.first) <= reach && dot(group.normal, face.areaNormal) > kLeastCosine * face.area;
}

void DepthIntegral::close(Group& group, ConePoints& points)
{
	group.isOpen = false;
	if (!(group.size > 0)) return;
	++m_count;
	m_volume += group.volume;
	points.add(m_origin + kPoint * (group.moment / group.size - m_origin), kAtPoint * group.volume, m_part);
}

void DepthIntegral::finishCones(ConePoints& points)
{
	for (Side& side : m_sides)
		if (side.group.isOpen) close(side.group, points);
	points.setWeight(m_tip, kAtTip * m_volume);
}

void DepthIntegral::addSample(const ConePoints& points, size_t point)
{
	m_sides[1].cones += points.weight(point) * points.depthInA(point);
	m_sides[0].cones += points.weight(point) * points.depthInB(point);
}

double DepthIntegral::mixed(const Side& side, double volume) const
{
	const double columns = side.energy * std::pow(std::min(volume / side.columns, kMostMissed), kPower);
	if (m_count == 0) return side.columns > 0 ? columns : 0;
	const bool isScaled = m_volume < kMostScaling * volume && volume < kMostScaling * m_volume;
	const double cones = std::max(0.0, side.cones) * (isScaled ? volume / m_volume : 1);
	if (!(side.columns > 0)) return cones;
	const double missed = missedShare(side.columns, volume);
	const double ofCones = kErrorOfCones / std::pow(double(m_count), 1.5), ofColumns = kErrorOfColumns + kErrorOfMissing * missed;
	const double share = std::clamp((missed - kNoCones) / (kAllCones - kNoCones), 0.0, 1.0);
	const double weight = share * ofColumns * ofColumns / (ofCones * ofCones + ofColumns * ofColumns);
	return std::max((1 - weight) * columns + weight * cones, kLeastOfColumns * columns);
}

void DepthIntegral::finish(double volume)
{
	for (Side& side : m_sides) side.result = volume > 0 ? mixed(side, volume) : 0;
}
}  // namespace ist
