// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/PairLaws.h"

#include "BulletISTCollision/Core/Tree/TreePose.h"

#include <numbers>

namespace ist
{
namespace
{
/// Lens of two balls: two spherical caps.
struct Lens
{
	Vec3 n;               ///< unit vector from the ball of B to that of A; 0 for coincident centres
	double distance = 0;  ///< distance of the centres
	double area = 0;
	double xA = 0, xB = 0;      ///< distances of the centres from the plane of the disc
	double capA = 0, capB = 0;  ///< volume of the part of the lens inside A's sphere beyond the disc, and of the part inside B's sphere
	double volume() const { return capA + capB; }
	Vec3 centroid(const Vec3& centerA) const { return volume() > 0 ? centerA - n * (distance * capB / volume()) : centerA; }
};

double ballVolume(double r) { return 4.0 / 3.0 * std::numbers::pi * r * r * r; }

double capVolume(double r, double x) { return std::numbers::pi / 3 * (r - x) * (r - x) * (2 * r + x); }

Lens lensOf(const Vec3& a, double rA, const Vec3& b, double rB)
{
	Lens lens;
	const Vec3 d = a - b;
	lens.distance = norm(d);
	lens.n = normalized(d);
	if (lens.distance >= rA + rB) return lens;
	if (lens.distance <= std::fabs(rA - rB))
	{
		(rA < rB ? lens.capA : lens.capB) = ballVolume(rA < rB ? rA : rB);
		return lens;
	}
	lens.xA = (lens.distance * lens.distance + (rA - rB) * (rA + rB)) / (2 * lens.distance);
	lens.xB = lens.distance - lens.xA;
	lens.area = std::numbers::pi * (rA - lens.xA) * (rA + lens.xA);
	lens.capA = capVolume(rA, lens.xA);
	lens.capB = capVolume(rB, lens.xB);
	return lens;
}
}  // namespace

PairLawResult paperLaw(
	const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const OverlapPair* pairs, int pairCount, double epsilon)
{
	PairLawResult sum;
	const Pose X = treePose(A, B, X_AB);
	for (int k = 0; k < pairCount; ++k)
	{
		const MomentEllipsoid i = A.inner.ball(pairs[k].ballA);
		const MomentEllipsoid j = B.inner.ball(pairs[k].ballB);
		const Lens lens = lensOf(i.center(), i.R, X * j.center(), j.R);
		const Vec3 f = lens.n * (epsilon * i.density * j.density * lens.volume());
		sum.wrench.force += f;
		sum.wrench.torque += cross(lens.centroid(i.center()), f);
	}
	return sum;
}

PairLawResult energyLaw(
	const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, const OverlapPair* pairs, int pairCount, const PressurePair& pair)
{
	PairLawResult sum;
	const Pose X = treePose(A, B, X_AB);
	for (int k = 0; k < pairCount; ++k)
	{
		const MomentEllipsoid i = A.law.ball(pairs[k].ballA);
		const MomentEllipsoid j = B.law.ball(pairs[k].ballB);
		const Vec3 a = i.center(), b = X * j.center();
		const double radiusA = i.meanRadius(), radiusB = j.meanRadius();
		const Lens lens = lensOf(a, radiusA, b, radiusB);
		const double scale = pair.stiffness * (i.volume() / ballVolume(radiusA)) * (j.volume() / ballVolume(radiusB));
		const Vec3 mA = i.normal() * pair.weightA, mB = X.rotation * j.normal() * pair.weightB;
		const double qA = pair.weightA * i.depth, qB = pair.weightB * j.depth;
		const Vec3 c = lens.centroid(a);
		sum.energy += scale * lens.volume() * (qA - dot(mA, c - a) + qB - dot(mB, c - b));

		const double pressure = qA + qB + dot(mA, lens.n) * lens.xA - dot(mB, lens.n) * lens.xB;
		const Vec3 f = scale * (lens.n * (lens.area * pressure) - mA * lens.capB + mB * lens.capA);
		sum.wrench.force += f;
		sum.wrench.torque += cross(a, f) - cross(mA, lens.n) * (scale * lens.distance * lens.capB);
	}
	return sum;
}
}  // namespace ist
