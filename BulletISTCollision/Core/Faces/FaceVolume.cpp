// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/FaceVolume.h"

#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <algorithm>
#include <iterator>

namespace ist
{
namespace
{
/// A direction is never taken as better than the worst by more than this factor of the error.
constexpr double kLeastVariance = 1e-6;
/// An axis is sure of its volume but for this many deviations.
constexpr double kSure = 4;
constexpr double kExact = 1e-6;  // error of a surface, as a share of the size of the faces together, that is only rounding

/// The axes of the coordinates where there are none.
void setPrincipalAxes(const SymmetricMatrix3& p, Vec3* axes)
{
	SymmetricEigen<3> eigen;
	const bool solved = p.trace() > 0 && eigen.decompose({{p.xx, p.xy, p.xz}, {p.xy, p.yy, p.yz}, {p.xz, p.yz, p.zz}});
	for (int k = 0; k < 3; ++k)
	{
		axes[k] = {};
		if (solved) axes[k] = {eigen.vectors[k][0], eigen.vectors[k][1], eigen.vectors[k][2]};
		else axes[k][k] = 1;
	}
}
}  // namespace

void FaceVolume::addArea(const ContactFace& face)
{
	if (!(face.area > 0)) return;
	m_area += face.area;
	m_centroid += face.area * face.center;
	const double weight = face.cut * face.cut;
	m_cuts += weight;
	m_rim += weight * face.center;
	m_spread += SymmetricMatrix3::square(face.center) * weight;
	m_normals += SymmetricMatrix3::square(face.areaNormal * (face.cut / face.area));
}

void FaceVolume::fit()
{
	if (m_area > 0) m_origin = m_centroid = m_centroid / m_area;
	if (m_cuts > 0) m_origin = m_rim / m_cuts;
	setPrincipalAxes(m_spread + SymmetricMatrix3::square(m_origin) * -m_cuts, m_axes);
	setPrincipalAxes(m_normals, m_axes + 3);
}

void FaceVolume::add(const ContactFace& face)
{
	const bool isInexact = face.error > kExact * std::sqrt(m_area);
	const Vec3 from = face.center - m_origin;
	for (int k = 0; k < kAxes; ++k)
	{
		const double flux = dot(from, m_axes[k]) * dot(face.areaNormal, m_axes[k]);
		const double own = dot(m_axes[k], face.spread * m_axes[k]);
		m_volumes[k] += flux + own;
		m_mostVolumes[k] += std::fabs(flux) + std::fabs(own);
		if (face.cut == 0) continue;
		const double gap = flux * face.cut / face.area;
		m_variance[k] += gap * gap;
		if (isInexact) m_inexact[k] += gap * gap;
	}
}

void FaceVolume::finish()
{
	double least = 0;  // volume that an axis is sure of
	for (int k = 0; k < kAxes; ++k) least = std::max(least, m_volumes[k] - kSure * std::sqrt(m_variance[k]));
	for (int k = 0; k < kAxes; ++k)
	{
		const double missing = std::max(least - m_mostVolumes[k], 0.0);
		m_variance[k] += missing * missing;
		m_inexact[k] += missing * missing;
	}
	const double largest = *std::max_element(std::begin(m_variance), std::end(m_variance));
	double sum = 0;
	for (int k = 0; k < kAxes; ++k) sum += m_weights[k] = largest > 0 ? 1 / (m_variance[k] + kLeastVariance * largest) : 1;
	for (double& weight : m_weights) weight /= sum;
	for (int k = 0; k < kAxes; ++k) m_volume += m_weights[k] * m_volumes[k];
}

double FaceVolume::combined(const double (&variance)[kAxes]) const
{
	double sum = 0;
	for (int k = 0; k < kAxes; ++k) sum += m_weights[k] * m_weights[k] * variance[k];
	return sum;
}
}  // namespace ist
