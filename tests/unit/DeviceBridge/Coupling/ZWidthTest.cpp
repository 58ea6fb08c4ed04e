// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/ZWidth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

using namespace devicebridge;

namespace
{
using Matrix = std::vector<std::vector<double>>;

/// Spectral radius by Gelfand's formula, |M^n|^(1/n), squaring twenty times.
double spectralRadius(Matrix m)
{
	double logScale = 0, power = 1;
	const std::size_t n = m.size();
	for (int k = 0; k < 20; ++k)
	{
		Matrix square(n, std::vector<double>(n));
		double norm = 0;
		for (std::size_t i = 0; i < n; ++i)
			for (std::size_t j = 0; j < n; ++j)
			{
				for (std::size_t l = 0; l < n; ++l) square[i][j] += m[i][l] * m[l][j];
				norm += square[i][j] * square[i][j];
			}
		norm = std::sqrt(norm);
		if (norm == 0) return 0;
		for (auto& row : square)
			for (double& v : row) v /= norm;
		logScale = 2 * logScale + std::log(norm);
		power *= 2;
		m = square;
	}
	return std::exp(logScale / power);
}

/// State (x, v, delayed forces): m v' = F - b v solved exactly over T, with F = -K x - B v from `delay` ticks before.
double closedLoopRadius(double m, double b, double K, double B, int delay)
{
	const double T = 1e-3, e = std::exp(-b * T / m);
	const double xv = m / b * (1 - e), vF = (1 - e) / b, xF = (T - m / b * (1 - e)) / b;
	const std::size_t n = 2 + static_cast<std::size_t>(delay);
	Matrix M(n, std::vector<double>(n));
	M[0][0] = 1, M[0][1] = xv, M[1][1] = e;
	if (delay == 0)
	{
		M[0][0] -= xF * K, M[0][1] -= xF * B;
		M[1][0] -= vF * K, M[1][1] -= vF * B;
		return spectralRadius(M);
	}
	M[0][2] = xF, M[1][2] = vF;
	for (std::size_t i = 2; i + 1 < n; ++i) M[i][i + 1] = 1;
	M[n - 1][0] = -K, M[n - 1][1] = -B;
	return spectralRadius(M);
}

double largestStableStiffness(double m, double b, double B, int delay)
{
	double low = 0, high = 4 * (b + B) / (0.5e-3 + 1e-3 * delay);
	for (int i = 0; i < 40; ++i)
	{
		const double middle = (low + high) / 2;
		(closedLoopRadius(m, b, middle, B, delay) < 1 ? low : high) = middle;
	}
	return low;
}
}  // namespace

TEST(ZWidth, AgreesWithTheEigenvaluesOfTheSampledLoop)
{
	for (const char* name : {"sigma7", "touchx"})
		for (const int delay : {0, 1, 3})
		{
			const SimulatedProfile profile = simulatedProfile(name).value();
			for (const ZWidthPoint& p : measureZWidth(profile, delay, {0, 1, 5}))
			{
				const double exact = largestStableStiffness(profile.mass, profile.damping, p.damping, delay);
				EXPECT_NEAR(p.stable, exact, 0.02 * exact) << name << ", B " << p.damping << ", delay " << delay;
				const double share = (profile.damping + p.damping) * (0.5e-3 + 1e-3 * delay) / profile.mass;
				if (share <= 0.02)
				{
					EXPECT_NEAR(p.stable, p.predicted, 0.05 * p.predicted) << name << ", B " << p.damping << ", delay " << delay;
				}
			}
		}
}

TEST(ZWidth, ThePassiveRegionLiesInTheStableOne)
{
	const SimulatedProfile profile = simulatedProfile("sigma7").value();
	for (const ZWidthPoint& p : measureZWidth(profile, 0, {0, 0.5, 1, 1.5}))
	{
		EXPECT_NEAR(p.passive, 2000 * (profile.damping - p.damping), 1e-9);
		EXPECT_LE(p.passive, p.stable * 1.02);
	}
}

TEST(ZWidth, TheMeasuredPassiveRegionIsThatOfColgateAndSchenkel)
{
	for (const char* name : {"sigma7", "touch", "falcon"})
	{
		const SimulatedProfile profile = simulatedProfile(name).value();
		const double b = profile.damping;
		for (const ZWidthPoint& p : measureZWidth(profile, 0, {0, 0.3 * b, 0.9 * b, 1.2 * b}))
			EXPECT_NEAR(p.passiveMeasured, p.passive, 1e-9 * (1 + p.passive)) << name << ", B " << p.damping;
		for (const bool quantised : {false, true})
			for (const int delay : {1, 5})
				for (const ZWidthPoint& p : measureZWidth(profile, delay, {0.3 * b}, quantised))
				{
					// Passive stiffness satisfies b > K T / 2 + |B|. With delay it is well below that, because slow motions already need b
					// > K (T / 2 + t_d) - B.
					EXPECT_LE(p.passiveMeasured, p.passive * 1.02) << name << ", B " << p.damping << ", delay " << delay;
					EXPECT_LE(p.passiveMeasured, p.predicted * 1.02) << name << ", B " << p.damping << ", delay " << delay;
					EXPECT_LE(p.passiveMeasured, p.stable * 1.02) << name << ", B " << p.damping << ", delay " << delay;
				}
	}
}

// The converse: just below the measured limit no motion of a hand takes energy out, and just above it the fastest shaking does.
TEST(ZWidth, NoMotionTakesEnergyOutOfAWallInThePassiveRegion)
{
	const SimulatedProfile profile = simulatedProfile("sigma7").value();
	std::mt19937_64 random(5);
	std::normal_distribution<double> normal;
	const double T = 1e-3, b = profile.damping;
	for (const ZWidthPoint& p : measureZWidth(profile, 0, {0, 0.5, 1.5}))
	{
		const auto absorbed = [&](const std::vector<double>& x, double K) {
			double energy = 0;
			const std::size_t n = x.size();
			for (std::size_t k = 0; k < n; ++k)
			{
				const double way = x[(k + 1) % n] - x[k], force = -K * x[k] - p.damping * (x[k] - x[(k + n - 1) % n]) / T;
				energy += b * way * way / T - force * way;
			}
			return energy;
		};
		for (int i = 0; i < 300; ++i)
		{
			// The motions range from random walks to white noise.
			std::vector<double> x(2 + random() % 60);
			double at = 0;
			for (double& v : x) v = at = (i % 10) / 10.0 * at + 1e-3 * normal(random);
			EXPECT_GE(absorbed(x, 0.999 * p.passiveMeasured), 0) << "B " << p.damping;
		}
		EXPECT_LT(absorbed({1e-3, -1e-3}, 1.001 * p.passiveMeasured), 0) << "B " << p.damping;
	}
}
