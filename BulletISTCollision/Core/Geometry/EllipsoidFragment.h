// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"

#include <algorithm>
#include <cmath>

namespace ist
{
/// The homogeneous ellipsoid with the volume, centroid and second moment of a part of a leaf (MomentEllipsoid.h). Cutting it gives two
/// fragments, whose moments add up to those of the whole.
struct EllipsoidFragment
{
	Vec3 center;
	SymmetricMatrix3 shape;  ///< P: five times the covariance [m^2]
	double volume = 0;       ///< volume of the body's matter in it [m^3]

	SymmetricMatrix3 spread() const { return shape * 0.2; }
	/// Half-width along a vector, times the vector's length.
	double width(const Vec3& direction) const { return std::sqrt(std::max(0.0, dot(direction, shape * direction))); }
};

/// A function that is approximately quadratic over a fragment.
struct LevelFunction
{
	double mean = 0;  ///< mean over the fragment
	Vec3 gradient;
	SymmetricMatrix3 curvature;  ///< second derivatives
};

/// A fragment, cut at the zero set of a level function as if by a plane. This is exact for a linear function and second order for others.
/// Share, centroids and moments are continuously differentiable in the function's values, also at either end, where one part vanishes.
class FragmentCut
{
public:
	FragmentCut(const EllipsoidFragment& piece, const LevelFunction& f) : m_piece(&piece)
	{
		const Vec3 conjugate = piece.shape * f.gradient;
		const double width = std::sqrt(std::max(0.0, dot(f.gradient, conjugate)));
		const double trace = dot(f.curvature, piece.shape), plain = f.mean - 0.1 * trace;
		if (!(width > 1e-9 * std::fabs(plain)))
		{
			m_height = plain > 0 ? 1 : -1;
			return;
		}
		m_axis = conjugate / width;
		// The fragment stands for a unit ball. Over its disc at the height -t, the mean square along the axis is t^2, and that along each
		// of the two other directions is (1 - t^2) / 4.
		const double along = dot(m_axis, f.curvature * m_axis), across = (trace - along) / 4;
		const double t = std::clamp(plain / width, -1.0, 1.0);
		const double bulge = 0.5 * (t * t * along + (1 - t * t) * across);
		m_height = std::clamp((plain + bulge) / width, -1.0, 1.0);
		m_slope = 0.75 * (1 - m_height * m_height) * std::max(0.0, 1 + t * (along - across) / width) / width;
	}

	/// Share of the fragment where the function is positive, and its derivative by the function's value.
	double share() const { return shareOf(1 + m_height); }
	double slope() const { return m_slope; }
	bool keepsAll() const { return m_height >= 1; }
	bool keepsNothing() const { return m_height <= -1; }

	EllipsoidFragment positive() const { return part(1 + m_height, 1); }
	EllipsoidFragment negative() const { return part(1 - m_height, -1); }
	/// The cut itself: a disc without thickness. Its `volume` is the volume of the whole fragment times `slope`.
	EllipsoidFragment disc() const
	{
		EllipsoidFragment d;
		d.center = m_piece->center - m_axis * m_height;
		d.shape = (m_piece->shape + SymmetricMatrix3::square(m_axis) * -1.0) * (1.25 * (1 - m_height * m_height));
		d.volume = m_piece->volume * m_slope;
		return d;
	}

private:
	static double shareOf(double h) { return h * h * (3 - h) / 4; }

	/// The cap of height h (in half-widths) on the side `sign` of the axis. Source: integrals over 1 - u^2 of a unit ball.
	EllipsoidFragment part(double h, double sign) const
	{
		if (h >= 2) return *m_piece;
		const double rest = 1 / (1 - h / 3), first = h * (2.0 / 3 - h / 4) * rest;  // mean distance from the pole
		const double along = 5 * (h * h * (0.5 - h / 5) * rest - first * first), across = 1.25 * h * (4.0 / 3 - h + h * h / 5) * rest;
		EllipsoidFragment p;
		p.center = m_piece->center + m_axis * (sign * (1 - first));
		p.shape = m_piece->shape * across + SymmetricMatrix3::square(m_axis) * (along - across);
		p.volume = m_piece->volume * shareOf(h);
		return p;
	}

	const EllipsoidFragment* m_piece;
	Vec3 m_axis;           // half-axis along which the function rises
	double m_height = -1;  // height of the centre above the cut, in half-widths, -1 to 1
	double m_slope = 0;
};
}  // namespace ist
