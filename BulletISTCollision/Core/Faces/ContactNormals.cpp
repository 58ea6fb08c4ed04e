// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/ContactNormals.h"

#include "BulletISTCollision/Core/Base/PlaneAxes.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
/// The mean normal of a plane is shorter by at most this: the rounding of a depth field.
constexpr double kPlane = 5e-9;
/// Mean normals that are shorter by more than this are of a body that goes around the other.
constexpr double kRound = 0.5;
/// One body is clearly smoother where the mean square of the normals across their mean is below this share of the other's.
constexpr double kMostOfRougher = 0.5;
/// Least cosine between the mean normal and those of the smoother body: it has no edges there.
constexpr double kLeastAlong = 0.95;
/// Least cosine between the mean gradient of a body without faces of its own and the mean normal of the other, times the gradient's length:
/// a face of a cube's corner still has 0.58, but not a cell that has an edge.
constexpr double kLeastAgreement = 0.55;
/// Least cosine that a normal is divided by.
constexpr double kLeastCosine = 0.5;
/// What is left of a pressure below this share is rounding: the face stands upright.
constexpr double kUpright = 1e-6;
/// Share of the force that projected pressures may miss: up to the first the normals are taken whole, from the second on not at all.
constexpr double kLittleMissed = 0.02, kMuchMissed = 0.03;
}  // namespace

void ContactNormals::Sum::add(const Vec3& normal, double weight)
{
	vector += weight * normal;
	area += weight;
	second += SymmetricMatrix3::square(normal) * weight;
}

double ContactNormals::Sum::spread() const { return area > 0 ? 1 - norm(vector) / area : 1; }

/// Mean of (n . a)(n . b).
double ContactNormals::Sum::across(const Vec3& a, const Vec3& b) const { return dot(a, second * b) / area; }

void ContactNormals::add(const ContactFace& face, double sign)
{
	const int body = sign > 0;
	const bool isCurved = !isFlat(face);
	m_sums[body].add(sign * (isCurved ? face.areaNormal / face.area : normalized(face.areaNormal)), face.area);
	m_sums[body].ownArea += face.area;
	m_sums[body].isCurved |= isCurved;
	const double length = norm(face.gradient);
	if (!(length > 0)) return;
	m_sums[1 - body].add((sign / length) * face.gradient, face.area);
	m_sums[1 - body].gradients += face.area * length;
}

double ContactNormals::findDirections(double& larger)
{
	Vec3 u, v;
	completeFrame(m_mean, u, v);
	const Sum &a = m_sums[0], &b = m_sums[1];
	const double uuA = a.across(u, u), vvA = a.across(v, v), uuB = b.across(u, u), vvB = b.across(v, v);
	// Along each of the axes of the difference one of the two is smoother.
	const PlaneAxes axes(uuA - uuB, vvA - vvB, a.across(u, v) - b.across(u, v));
	m_directions[0] = std::cos(axes.angle) * u + std::sin(axes.angle) * v;
	m_directions[1] = std::cos(axes.angle) * v - std::sin(axes.angle) * u;
	m_smootherAcross[0] = axes.larger > 0;
	m_smootherAcross[1] = axes.smaller > 0;
	larger = std::max(uuA + vvA, uuB + vvB);
	return 0.5 * (uuA + vvA + uuB + vvB - std::fabs(axes.larger) - std::fabs(axes.smaller));
}

void ContactNormals::find(bool hasFacesA, bool hasFacesB)
{
	m_smoother = -1;
	const bool hasFaces[2] = {hasFacesA, hasFacesB};
	double spread[2];
	for (int body = 0; body < 2; ++body)
	{
		spread[body] = m_sums[body].spread();
		// A few faces in one cell of a depth field see one gradient, whichever, and a short one where the cell has an edge. Where a body's
		// own faces are missing, those of the other must look along it.
		const Sum& sum = m_sums[body];
		const double agreement = dot(normalized(m_sums[0].vector), normalized(m_sums[1].vector));
		if (hasFaces[body] && !(sum.ownArea > 0) && !(agreement * sum.gradients > kLeastAgreement * sum.area)) spread[body] = 1;
	}
	const bool flatA = spread[0] < kPlane && !m_sums[0].isCurved, flatB = spread[1] < kPlane && !m_sums[1].isCurved;
	const int smoother = flatA ? 0 : flatB ? 1 : spread[1] < spread[0];
	if (!(spread[smoother] < kRound)) return;
	m_mean = normalized(m_sums[smoother].vector);
	m_areFlat = flatA || flatB;
	if (!m_areFlat)
	{
		double rougher = 0;
		const double across = findDirections(rougher);
		if (!(across < kMostOfRougher * rougher)) return;
	}
	m_smoother = smoother;
}

Vec3 ContactNormals::at(const ContactFace& face, double sign) const
{
	if (!exist()) return {};
	if (m_areFlat) return m_mean;
	const int own = sign > 0;
	const Vec3 ownNormal = sign * normalized(face.areaNormal), otherNormal = sign * normalized(face.gradient);
	Vec3 normal = m_mean;
	for (int i = 0; i < 2; ++i)
	{
		const Vec3& n = m_smootherAcross[i] == own ? ownNormal : otherNormal;
		normal += dot(n, m_directions[i]) / std::max(dot(n, m_mean), kLeastCosine) * m_directions[i];
	}
	return normalized(normal);
}

Vec3 ContactNormals::along(const Vec3& v, const Vec3& normal) const { return v - m_share * (v - dot(v, normal) * normal); }

void ContactNormals::measure(const ContactFace& face, double sign)
{
	if (!exist()) return;
	const int own = sign > 0;
	const Vec3 ofSmoother = sign * normalized(m_smoother == own ? face.areaNormal : face.gradient), normal = at(face, sign);
	m_hasEdges |= dot(ofSmoother, m_mean) < kLeastAlong;
	m_before[own] += dot(face.pressure, m_mean);
	m_after[own] += dot(face.pressure, normal) * dot(normal, m_mean);
}

void ContactNormals::settle()
{
	if (!exist()) return;
	const double size = std::fabs(m_before[0]) + std::fabs(m_before[1]),
				 missed = std::fabs(m_before[0] - m_after[0]) + std::fabs(m_before[1] - m_after[1]);
	m_share = size > 0 ? std::clamp((kMuchMissed - missed / size) / (kMuchMissed - kLittleMissed), 0.0, 1.0) : 0;
	if (m_hasEdges || m_share == 0) m_smoother = -1, m_share = 0;
}

Vec3 ContactNormals::pressure(const ContactFace& face, double sign, const Vec3& normal) const
{
	if (!exist()) return face.pressure;
	const int own = sign > 0;
	const double size = dot(face.pressure, normal), restored = m_after[own] != 0 ? m_before[own] / m_after[own] : 1;
	// What rounding leaves of an upright face is no pressure.
	const bool isUpright = !(size * size > kUpright * kUpright * squaredNorm(face.pressure));
	const Vec3 projected = isUpright ? Vec3() : size * restored * normal;
	return face.pressure - m_share * (face.pressure - projected);
}
}  // namespace ist
