// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/MomentEllipsoid.h"

#include <algorithm>

namespace ist
{
constexpr double kPi = 3.14159265358979323846;

inline double ballVolume(double R) { return 4.0 / 3.0 * kPi * R * R * R; }

/// Intersection of two balls i and j: two spherical caps, each with its volume and centroid.
struct Lens
{
	double volume = 0;          ///< L = capI + capJ
	double area = 0;            ///< area of the disc that both spheres share; 0 if one ball contains the other
	double capI = 0, capJ = 0;  ///< cap of ball i (or j) beyond the disc
	Vec3 normal;                ///< from j to i; zero if the balls are concentric
	Vec3 centroid;
};

/// False if the balls do not intersect. Heights are products of differences of lengths, so that thin lenses keep their digits.
inline bool lensOf(const Vec3& ci, double Ri, const Vec3& cj, double Rj, Lens& lens)
{
	const Vec3 offset = ci - cj;
	const double squared = squaredNorm(offset), reach = Ri + Rj;
	if (!(squared < reach * reach) || !(Ri > 0 && Rj > 0)) return false;
	const double D = std::sqrt(squared);
	// A distance of zero must take this branch: equal concentric balls share everything.
	if (D <= std::fabs(Ri - Rj))
	{
		const bool jInside = Rj <= Ri;
		lens.volume = ballVolume(jInside ? Rj : Ri);
		lens.area = 0;
		lens.capI = jInside ? 0 : lens.volume;
		lens.capJ = jInside ? lens.volume : 0;
		lens.normal = D > 0 ? offset / D : Vec3{};
		lens.centroid = jInside ? cj : ci;
		return true;
	}
	const double overlap = reach - D;
	if (!(overlap > 0)) return false;
	const double inverse = 1 / D, half = 0.5 * overlap * inverse;
	const double hi = (Rj - Ri + D) * half, hj = (Ri - Rj + D) * half;
	lens.capI = kPi / 3 * hi * hi * (3 * Ri - hi);
	lens.capJ = kPi / 3 * hj * hj * (3 * Rj - hj);
	lens.volume = lens.capI + lens.capJ;
	if (!(lens.volume > 0)) return false;
	lens.area = kPi * hi * (2 * Ri - hi);
	lens.normal = offset * inverse;
	// The first moment about ci, along -n, is D capJ.
	lens.centroid = ci - offset * (lens.capJ / lens.volume);
	return true;
}

/// Intersection of a ball with the half-space below a plane. `height` is the height of the ball's centre above the plane, and `normal`
/// points up. Only volume, area, normal and centroid are filled.
inline bool capOf(const Vec3& c, double R, const Vec3& normal, double height, Lens& cap)
{
	if (!(height < R) || !(R > 0)) return false;
	cap.normal = normal;
	if (height <= -R)
	{
		cap.volume = ballVolume(R);
		cap.area = 0;
		cap.centroid = c;
		return true;
	}
	const double h = R - height, rest = R + height;
	cap.volume = kPi * h * h * (3 * R - h) / 3;
	cap.area = kPi * h * rest;
	cap.centroid = c - normal * (0.75 * rest * rest / (3 * R - h));
	return cap.volume > 0;
}

/// Overlap of two ellipsoids (P; R: radius of the bounding ball), in units of the densities. In coordinates in which P_i + P_j is the
/// identity, each ellipsoid is replaced by the ball with its mean second moment. This is exact for two balls and for two ellipsoids of
/// one shape. Such balls can reach farther than the ellipsoids. Where they would reach beyond the bounding balls, they touch when the
/// bounding balls do. `normal` and `area` are direction and size of minus the gradient of the volume by c_i - c_j.
inline bool lensOf(const Vec3& ci, double Ri, const SymmetricMatrix3& Pi, const Vec3& cj, double Rj, const SymmetricMatrix3& Pj, Lens& lens)
{
	const Vec3 offset = ci - cj;
	const double reach = Ri + Rj, length = norm(offset);
	if (!(length < reach) || !(Ri > 0 && Rj > 0)) return false;
	const SymmetricMatrix3 P = Pi + Pj, Q = adjugate(P);
	const double det = determinant(P);
	const double ri = std::sqrt(dot(Pi, Q) / (3 * det)), rj = std::sqrt(dot(Pj, Q) / (3 * det));
	Vec3 slope = Q * offset / det;  // gradient of the distance D in those coordinates, times D
	double D = std::sqrt(std::max(0.0, dot(offset, slope)));
	if (const double share = (ri + rj) / reach; D < share * length)
	{
		D = share * length;
		slope = offset * (share * share);
	}
	Lens round;
	if (!lensOf({D, 0, 0}, ri, {}, rj, round)) return false;
	const double scale = Ri * Ri * Ri * Rj * Rj * Rj / (ri * ri * ri * rj * rj * rj * std::sqrt(det));
	const double steepness = norm(slope);
	lens.volume = scale * round.volume;
	lens.area = D > 0 ? scale * round.area * steepness / D : 0;
	lens.capI = scale * round.capI;
	lens.capJ = scale * round.capJ;
	lens.normal = steepness > 0 ? slope / steepness : Vec3{};
	lens.centroid = ci - offset * (round.capJ / round.volume);
	return true;
}

/// Centroid of the lens of two ellipsoids. For unlike shapes it lies off the line of their centres: across the thin side of a flat
/// ellipsoid it hardly leaves the centre, however far away a large one beside it is. With the share s of ball j's cap in `lens`, and with
/// r_i, r_j of lensOf():
///     c = c_i - s r_j^2 P_i N^-1 (c_i - c_j),   N = s r_j^2 P_i + (1 - s) r_i^2 P_j
/// For two ellipsoids of one shape it lies on the line; if one contains the other, it is the inner one's centre. It is an estimate, as
/// the lens is: where two flat ellipsoids share little, it may lie outside of them. It matters where a quantity changes across an
/// ellipsoid.
inline Vec3 lensCentroid(const Lens& lens, const Vec3& ci, const SymmetricMatrix3& Pi, const Vec3& cj, const SymmetricMatrix3& Pj)
{
	const double share = lens.capJ / lens.volume;
	const SymmetricMatrix3 Q = adjugate(Pi + Pj);
	const double ofI = share * dot(Pj, Q), ofJ = (1 - share) * dot(Pi, Q);
	const SymmetricMatrix3 N = (Pi * ofI + Pj * ofJ) * (1 / (ofI + ofJ));
	return ci - Pi * (adjugate(N) * (ci - cj)) * (ofI / (ofI + ofJ) / determinant(N));
}

/// Intersection of an ellipsoid with the half-space below a plane, as for the ball; exact. In units of the ellipsoid's density.
inline bool capOf(const MomentEllipsoid& e, const Vec3& normal, double height, Lens& cap)
{
	const Vec3 conjugate = e.shape() * normal;
	const double squared = dot(normal, conjugate), width = std::sqrt(squared), R = e.R;
	if (!capOf({}, width, normal, height, cap)) return false;
	const double scale = R * R * R / (squared * width);
	cap.volume *= scale;
	cap.area *= scale;
	cap.centroid = e.center() + conjugate * (dot(cap.centroid, normal) / squared);
	return true;
}
}  // namespace ist
