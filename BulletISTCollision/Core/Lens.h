// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Vec3.h"

namespace ist
{
constexpr double kPi = 3.14159265358979323846;

inline double ballVolume(double R) { return 4.0 / 3.0 * kPi * R * R * R; }

/// Intersection of two balls i and j. Source: reference/force-law.md 2.
struct Lens
{
	double volume = 0;      ///< L = capI + capJ
	double area = 0;        ///< of the disc that both spheres share; 0 when one ball contains the other
	double capI = 0, capJ = 0;  ///< cap of ball i (of j) beyond the disc
	Vec3 normal;            ///< from j to i; zero when concentric
	Vec3 centroid;
};

/// False when the balls do not intersect. Heights are products of differences of lengths, so that thin lenses keep their digits.
inline bool lensOf(const Vec3& ci, double Ri, const Vec3& cj, double Rj, Lens& lens)
{
	const Vec3 offset = ci - cj;
	const double squared = squaredNorm(offset), reach = Ri + Rj;
	if (!(squared < reach * reach) || !(Ri > 0 && Rj > 0)) return false;
	const double D = std::sqrt(squared);
	// A distance of zero must land here: equal concentric balls share everything.
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
	// First moment from ci along -n is D capJ.
	lens.centroid = ci - offset * (lens.capJ / lens.volume);
	return true;
}

/// Ball against the half-space below a plane; `height` is that of the ball's centre above it, `normal` points up.
/// Only volume, area, normal and centroid are filled.
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
}  // namespace ist
