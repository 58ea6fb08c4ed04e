// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/GraspQuality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

using namespace devicebridge;
using ist::Vec3;

namespace
{
using Wrench6 = std::array<double, 6>;

/// Corners of the cones, from their definition.
std::vector<Wrench6> corners(const std::vector<GraspContact>& contacts, const GraspQualityOptions& o)
{
	std::vector<Wrench6> all;
	for (const GraspContact& c : contacts)
	{
		Vec3 t1, t2;
		completeFrame(c.normal, t1, t2);
		const auto add = [&](const Vec3& f, const Vec3& more) {
			const Vec3 m = (cross(c.point, f) + more) / o.length;
			all.push_back({f.x, f.y, f.z, m.x, m.y, m.z});
		};
		for (int i = 0; i < o.edges; ++i)
			add(c.normal +
					c.friction * (std::cos(2 * std::numbers::pi * i / o.edges) * t1 + std::sin(2 * std::numbers::pi * i / o.edges) * t2),
				{});
		for (const double s : {-1.0, 1.0}) add(c.normal, s * c.friction * c.frictionRadius * c.normal);
	}
	return all;
}

/// Least support of the corners over many directions, each then improved by random steps. It is a close upper bound.
double leastSupport(const std::vector<Wrench6>& all, unsigned seed)
{
	std::mt19937 random(seed);
	std::normal_distribution<double> gauss;
	const auto unit = [](Wrench6 u) {
		double n = 0;
		for (const double x : u) n += x * x;
		for (double& x : u) x /= std::sqrt(n);
		return u;
	};
	const auto support = [&](const Wrench6& u) {
		double most = -1e300;
		for (const Wrench6& w : all)
		{
			double sum = 0;
			for (int i = 0; i < 6; ++i) sum += w[size_t(i)] * u[size_t(i)];
			most = std::max(most, sum);
		}
		return most;
	};
	double least = 1e300;
	for (int start = 0; start < 30; ++start)
	{
		Wrench6 u;
		for (double& x : u) x = gauss(random);
		u = unit(u);
		double best = support(u);
		for (double step = 0.5; step > 1e-6; step *= 0.985)
			for (int i = 0; i < 8; ++i)
			{
				Wrench6 v = u;
				for (double& x : v) x += step * gauss(random);
				v = unit(v);
				if (const double s = support(v); s < best) best = s, u = v;
			}
		least = std::min(least, best);
	}
	return least;
}

std::vector<GraspContact> pairOnSphere(double friction, double frictionRadius)
{
	return {{{1, 0, 0}, {-1, 0, 0}, friction, frictionRadius}, {{-1, 0, 0}, {1, 0, 0}, friction, frictionRadius}};
}
const GraspQualityOptions kFourEdges{1, 4, 200000};
}  // namespace

TEST(GraspQuality, TwoHardPointsCannotHoldATurnAboutTheirLine)
{
	const GraspQuality quality = graspQuality(pairOnSphere(0.5, 0), kFourEdges);
	EXPECT_FALSE(quality.forceClosure);
	EXPECT_EQ(quality.epsilon, 0);
}

// With friction m and drilling g = m r, the support along (a, b) has two candidates for its minimum. One is at a_x = 0, with 1 / sqrt(1 /
// g^2 + 2 / m^2). The other is where only the normal force acts, with 1 / sqrt(1 + 4 / m^2).
TEST(GraspQuality, SoftPairOnASphereHasTheClosedForm)
{
	for (const double m : {0.3, 0.5, 1.0, 2.0})
		for (const double r : {0.1, 0.5, 1.0, 3.0})
		{
			const double expected = 1 / std::sqrt(std::max(1 / (m * m * r * r) + 2 / (m * m), 1 + 4 / (m * m)));
			const GraspQuality quality = graspQuality(pairOnSphere(m, r), kFourEdges);
			EXPECT_TRUE(quality.forceClosure);
			EXPECT_TRUE(quality.exact);
			EXPECT_NEAR(quality.epsilon, expected, 1e-4 * expected) << m << " " << r;
		}
}

// For six contacts along the axes, the weakest wrench is a torque along a diagonal of the cube, m / sqrt(3).
TEST(GraspQuality, SixContactsOnASphereHaveTheClosedForm)
{
	for (const double m : {0.1, 0.3, 0.5})
	{
		std::vector<GraspContact> contacts;
		for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
			for (const double s : {-1.0, 1.0}) contacts.push_back({s * n, -s * n, m, 0});
		const GraspQuality quality = graspQuality(contacts, kFourEdges);
		EXPECT_TRUE(quality.forceClosure);
		EXPECT_NEAR(quality.epsilon, m / std::sqrt(3), 1e-5);
	}
}

TEST(GraspQuality, IsTheLeastSupportOfTheCornersForRandomGrasps)
{
	std::mt19937 random(11);
	std::uniform_real_distribution<double> any(-1, 1);
	int closed = 0;
	for (int n = 0; n < 12; ++n)
	{
		std::vector<GraspContact> contacts;
		for (int i = 0; i < 3 + n % 4; ++i)
		{
			const Vec3 p = normalized(Vec3{any(random), any(random), any(random)});
			contacts.push_back({0.05 * p, normalized(-p + 0.2 * Vec3{any(random), any(random), any(random)}), 0.6, 0.01});
		}
		const GraspQualityOptions options{0.05, 6, 200000};
		const GraspQuality quality = graspQuality(contacts, options);
		const double least = leastSupport(corners(contacts, options), unsigned(n));
		EXPECT_TRUE(quality.exact);
		EXPECT_EQ(quality.forceClosure, least > 1e-4) << n << " " << least;
		if (!quality.forceClosure) continue;
		++closed;
		EXPECT_LE(quality.epsilon, least + 1e-5);
		EXPECT_NEAR(quality.epsilon, least, 0.02 * least);
	}
	EXPECT_GE(closed, 4);
}

TEST(GraspQuality, NothingToHoldWithIsNoClosure)
{
	EXPECT_FALSE(graspQuality({}).forceClosure);
	std::vector<GraspContact> bad = pairOnSphere(0.5, 1);
	bad[0].point.x = std::numeric_limits<double>::quiet_NaN();
	EXPECT_FALSE(graspQuality(bad, kFourEdges).forceClosure);
	EXPECT_FALSE(graspQuality({{{1, 0, 0}, {0, 0, 0}, 0.5, 1}}).forceClosure);
	EXPECT_FALSE(graspQuality(pairOnSphere(0, 1), kFourEdges).forceClosure);
	EXPECT_FALSE(graspQuality(pairOnSphere(0.5, 1), {0, 8, 100}).forceClosure);
}

TEST(GraspQuality, EndsForPointsOfEverySize)
{
	std::mt19937 random(5);
	std::uniform_real_distribution<double> any(-1, 1);
	for (const double size : {1e-12, 1e-3, 1e3, 1e6, 1e9, 1e15, 1e100, 1e160, 1e300})
		for (const double length : {1e-300, 1e-15, 1e-9, 1e-5, 1.0, 1e12})
		{
			std::vector<GraspContact> contacts;
			for (int i = 0; i < 5; ++i)
			{
				const Vec3 p = normalized(Vec3{any(random), any(random), any(random)});
				contacts.push_back({size * p, -p, 0.6, 0.01 * size});
			}
			const GraspQuality quality = graspQuality(contacts, {length, 6, 5000});
			EXPECT_TRUE(std::isfinite(quality.epsilon)) << size << " " << length;
			EXPECT_GE(quality.epsilon, 0);
			// No normal force of 1 N resists more than the longest edge of a cone, sqrt(1 + 0.6^2) N.
			EXPECT_LE(quality.epsilon, 1.2) << size << " " << length;
			EXPECT_LE(quality.iterations, quality.wrenches);
		}
}
