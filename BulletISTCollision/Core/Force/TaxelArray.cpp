// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/TaxelArray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace ist
{
namespace
{
constexpr double kUnit = 1e-3;

double weightOf(const Taxel& taxel, const Vec3& x, const Vec3& force)
{
	const double near = 1 - squaredNorm(x - taxel.position) / (taxel.radius * taxel.radius);
	return near > 0 && dot(force, taxel.normal) < 0 ? near * near : 0;
}
}  // namespace

Result<TaxelArray> TaxelArray::make(std::vector<Taxel> taxels)
{
	for (size_t i = 0; i < taxels.size(); ++i)
	{
		const Taxel& t = taxels[i];
		const auto refused = [&](const char* why) { return Error{"taxel " + std::to_string(i) + ": " + why}; };
		if (!isFinite(t.position) || !isFinite(t.normal)) return refused("its position or normal is not finite");
		if (!(std::fabs(norm(t.normal) - 1) < kUnit)) return refused("its normal must have unit length");
		if (!(t.radius > 0) || !std::isfinite(t.radius)) return refused("its radius must be positive");
	}
	TaxelArray array;
	array.m_forces.resize(taxels.size());
	array.m_weights.resize(taxels.size());
	array.m_leastRadius = std::numeric_limits<double>::infinity();
	for (const Taxel& t : taxels) array.m_leastRadius = std::min(array.m_leastRadius, t.radius);
	array.m_taxels = std::move(taxels);
	return array;
}

void TaxelArray::clear()
{
	std::fill(m_forces.begin(), m_forces.end(), Vec3());
	m_rest = {};
}

/// Shares a force that acts at a point among the taxels. Mesh frame of the body.
void TaxelArray::addForce(const Vec3& x, const Vec3& force)
{
	double sum = 0;
	for (size_t t = 0; t < m_taxels.size(); ++t) sum += m_weights[t] = weightOf(m_taxels[t], x, force);
	const double share = 1 / std::max(1.0, sum);
	double felt = 0;
	for (size_t t = 0; t < m_taxels.size(); ++t)
	{
		if (!(m_weights[t] > 0)) continue;
		m_forces[t] += (share * m_weights[t]) * force;
		felt += share * m_weights[t];
	}
	m_rest += (1 - felt) * force;
}

/// The pressure changes linearly over the rectangle, and is nowhere negative. The shares are divided by their sum, so that all parts have
/// the force of the point.
void TaxelArray::addDivided(const ContactPoint& point, const int (&parts)[2], const Pose& X_TP, double sign)
{
	const auto forParts = [&](const auto& function) {
		for (int i = 0; i < parts[0]; ++i)
			for (int k = 0; k < parts[1]; ++k)
			{
				const Vec3 arm = ((2 * i + 1.0) / parts[0] - 1) * point.sides[0] + ((2 * k + 1.0) / parts[1] - 1) * point.sides[1];
				function(arm, std::max(0.0, point.pressure + dot(point.slope, arm)));
			}
	};
	double sum = 0;
	forParts([&](const Vec3&, double pressure) { sum += pressure; });
	const Vec3 force = (sign / sum) * (X_TP.rotation * point.force());
	forParts([&](const Vec3& arm, double pressure) {
		if (pressure > 0) addForce(X_TP * (point.center + arm), pressure * force);
	});
}

void TaxelArray::add(const ContactPoint* points, size_t count, const Pose& X_TP, double sign)
{
	for (size_t i = 0; i < count; ++i)
	{
		const ContactPoint& point = points[i];
		int parts[2];
		for (int k = 0; k < 2; ++k)
			parts[k] = int(std::clamp(std::ceil(4 * norm(point.sides[k]) / m_leastRadius), 1.0, double(kMostParts)));
		if (parts[0] * parts[1] > 1 && point.pressure > 0) addDivided(point, parts, X_TP, sign);
		else addForce(X_TP * point.position, sign * (X_TP.rotation * point.force()));
	}
}
}  // namespace ist
