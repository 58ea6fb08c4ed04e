// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/TaxelArray.h"

#include <algorithm>
#include <cmath>
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
	array.m_taxels = std::move(taxels);
	return array;
}

void TaxelArray::clear()
{
	std::fill(m_forces.begin(), m_forces.end(), Vec3());
	m_rest = {};
}

void TaxelArray::add(const ContactPoint* points, size_t count, const Pose& X_TP, double sign)
{
	for (size_t i = 0; i < count; ++i)
	{
		const Vec3 x = X_TP * points[i].position, force = sign * (X_TP.rotation * points[i].force());
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
}
}  // namespace ist
