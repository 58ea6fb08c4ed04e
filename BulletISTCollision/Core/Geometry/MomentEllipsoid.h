// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"
#include "BulletISTCollision/Core/Geometry/SpherePacking.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace ist
{
/// Volume of a ball of radius 1 m [m^3].
inline constexpr double kUnitBall = 4.18879020478639098462;

/// The homogeneous ellipsoid that has the volume, centroid and second moment of a piece of the body, with that piece's mean outward
/// normal and mean depth. Its points are c + y with y^T P^-1 y <= 1, where P is five times the piece's covariance; P = R^2 for a ball.
/// Its density is below 1, because no piece is an ellipsoid. It takes one cache line.
struct alignas(64) MomentEllipsoid
{
	float x = 0, y = 0, z = 0;     ///< centroid c
	float R = 0;                   ///< radius of a ball around the ellipsoid, a little larger than its longest half-axis [m]
	float density = 0;             ///< d, no unit: volume of the piece over that of the bounding ball
	float nx = 0, ny = 0, nz = 0;  ///< mean outward normal of the nearest surface points; NOT of unit length
	float depth = 0;               ///< mean depth under the surface [m]
	uint32_t sphere = 0;           ///< index of the packed sphere to whose cell the piece belongs
	float xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;  ///< P [m^2]

	Vec3 center() const { return {x, y, z}; }
	Vec3 normal() const { return {nx, ny, nz}; }
	SymmetricMatrix3 shape() const { return {xx, yy, zz, xy, xz, yz}; }
	/// Radius of the ball with the same mean second moment [m].
	double meanRadius() const { return std::sqrt((double(xx) + yy + zz) / 3); }
	double volume() const { return double(density) * R * R * R * kUnitBall; }

	void setPlace(const Vec3& c) { x = float(c.x), y = float(c.y), z = float(c.z); }
	void setNormal(const Vec3& m) { nx = float(m.x), ny = float(m.y), nz = float(m.z); }
	void setShape(const SymmetricMatrix3& P)
	{
		xx = float(P.xx), yy = float(P.yy), zz = float(P.zz), xy = float(P.xy), xz = float(P.xz), yz = float(P.yz);
	}
	/// Smallest ratio of the half-axes, shortest over longest. At this ratio the queries' floats still find distances to 0.05 %.
	static constexpr double kFlattest = 1.0 / 20;
	/// The eigenvalues of a solid shape lie between these factors times R^2. The margins cover the rounding of StoredEllipsoid to steps
	/// of 3e-5.
	static constexpr double kLeastShape = 0.5 * kFlattest * kFlattest, kMostShape = 1 + 1e-4;
	/// True if the density is positive, R lies between 1e-12 and 1e12 m (powers of such lengths fit into a float), the ball of radius R
	/// contains the shape, and the shape is flat in no direction.
	bool isSolid() const;
	static bool isRadius(float R) { return (R > 1e-12) & (R < 1e12); }
};
static_assert(sizeof(MomentEllipsoid) == 64);

/// Whether a symmetric matrix is positive definite; its diagonal comes first.
template <class Number> constexpr bool isPositiveDefinite(Number xx, Number yy, Number zz, Number xy, Number xz, Number yz)
{
	const Number minor = xx * yy - xy * xy;
	return (xx > 0) & (minor > 0) & (minor * zz - xx * yz * yz - yy * xz * xz + 2 * xy * xz * yz > 0);
}

inline bool MomentEllipsoid::isSolid() const
{
	const double low = kLeastShape * R * R, high = kMostShape * R * R;
	const bool thick = isPositiveDefinite<double>(xx - low, yy - low, zz - low, xy, xz, yz);
	const bool inBall = isPositiveDefinite<double>(high - xx, high - yy, high - zz, -double(xy), -double(xz), -double(yz));
	return isRadius(R) && density > 0 && thick && inBall;
}

/// The part of a MomentEllipsoid that a tree stores beside its bounding ball: half a cache line. Normal and shape have steps of 3e-5, far
/// below the accuracy of a piece's samples.
struct alignas(32) StoredEllipsoid
{
	static constexpr float kStep = 1.0f / 32767;
	float density = 0, depth = 0;
	int16_t normal[3] = {}, unused = 0;  ///< mean normal in units of kStep
	int16_t shape[6] = {};               ///< P in units of kStep R^2: xx, yy, zz, xy, xz, yz
	uint32_t sphere = 0;

	StoredEllipsoid() = default;
	explicit StoredEllipsoid(const MomentEllipsoid& ellipsoid);  ///< rounded
	/// The ellipsoid in `bound`, the ball of radius R around its centroid.
	MomentEllipsoid in(const Sphere& bound) const;
	/// If true, the ellipsoid is solid in every bound with a valid radius. Computed exactly, in integers.
	bool isSolid() const;
};
static_assert(sizeof(StoredEllipsoid) == 32);

inline MomentEllipsoid StoredEllipsoid::in(const Sphere& bound) const
{
	MomentEllipsoid e;
	e.x = bound.x, e.y = bound.y, e.z = bound.z, e.R = bound.r;
	e.density = density, e.depth = depth, e.sphere = sphere;
	e.nx = normal[0] * kStep, e.ny = normal[1] * kStep, e.nz = normal[2] * kStep;
	const float scale = bound.r * bound.r * kStep;
	e.xx = shape[0] * scale, e.yy = shape[1] * scale, e.zz = shape[2] * scale;
	e.xy = shape[3] * scale, e.xz = shape[4] * scale, e.yz = shape[5] * scale;
	return e;
}

inline bool StoredEllipsoid::isSolid() const
{
	constexpr int64_t kMost = int64_t(MomentEllipsoid::kMostShape / double(kStep)),
					  kLeast = 1 + int64_t(MomentEllipsoid::kLeastShape / double(kStep));
	const int64_t xx = shape[0], yy = shape[1], zz = shape[2], xy = shape[3], xz = shape[4], yz = shape[5];
	const bool thick = isPositiveDefinite<int64_t>(xx - kLeast, yy - kLeast, zz - kLeast, xy, xz, yz);
	const bool inBall = isPositiveDefinite<int64_t>(kMost - xx, kMost - yy, kMost - zz, -xy, -xz, -yz);
	return density > 0 && thick && inBall;
}

/// Gradient of the mean outward normal over an ellipsoid, a symmetric matrix G: the normal at x is m + G (x - c). Two entries share a
/// word, each the upper half of a float. They are accurate to 0.4 %, which is small beside the error of a linear function.
struct alignas(16) NormalGradient
{
	uint32_t diagonalOverRest[3] = {};  ///< xx above xy, yy above xz, zz above yz [1/m]
	uint32_t unused = 0;

	SymmetricMatrix3 matrix() const;
	void setMatrix(const SymmetricMatrix3& G);  ///< rounded
};
static_assert(sizeof(NormalGradient) == 16);

/// The ellipsoid of a whole ball, without normal and depth.
inline MomentEllipsoid ballOf(const Sphere& sphere, uint32_t index)
{
	MomentEllipsoid ball;
	ball.setPlace(sphere.center());
	ball.R = sphere.r;
	ball.density = 1;
	ball.sphere = index;
	ball.xx = ball.yy = ball.zz = sphere.r * sphere.r;
	return ball;
}

/// The ellipsoid of a piece with this volume. The shape is kept except where it comes from too few samples: an ellipsoid of less than a
/// third of the piece's volume is enlarged to that, and half-axes of less than a twentieth of the longest are lengthened to that. Normal,
/// depth and sphere stay empty.
MomentEllipsoid momentEllipsoid(const Vec3& centroid, const SymmetricMatrix3& shape, double volume);

/// The union of some pieces, given by index. Volumes add up, moments are exact, normal and depth are means weighted by volume.
MomentEllipsoid merged(const MomentEllipsoid* pieces, const uint32_t* index, size_t count);
/// The symmetric gradient that fits the normals of the pieces best, weighted by volume; each piece has one normal throughout. It is
/// symmetric because normals are minus the gradient of the depth. G solves G S + S G = C + C^T. S is the second moment of `whole`, which
/// is merged from these pieces, about its centroid, and C = Sum V (n - m) (x - c)^T over the pieces. Zero for one piece.
SymmetricMatrix3 normalGradient(const MomentEllipsoid& whole, const MomentEllipsoid* pieces, const uint32_t* index, size_t count);
}  // namespace ist
