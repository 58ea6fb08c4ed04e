// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/AdaptiveCoupling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

using namespace devicebridge;

namespace
{
constexpr double kTick = 1e-3, kInf = std::numeric_limits<double>::infinity();
using Matrix = std::array<std::array<double, 6>, 6>;

CouplingGains bounds(double most)
{
	CouplingGains gains{1000, 2, 0, 0, 12, 0.5};
	gains.softContact = most;
	return gains;
}

double bound(int i) { return i < 3 ? 1000 : 2; }

/// A^-1 B by Gauss-Jordan elimination.
Matrix divided(Matrix a, Matrix b)
{
	for (std::size_t k = 0; k < 6; ++k)
	{
		std::size_t best = k;
		for (std::size_t i = k; i < 6; ++i)
			if (std::fabs(a[i][k]) > std::fabs(a[best][k])) best = i;
		std::swap(a[k], a[best]);
		std::swap(b[k], b[best]);
		for (std::size_t i = 0; i < 6; ++i)
		{
			if (i == k) continue;
			const double f = a[i][k] / a[k][k];
			for (std::size_t j = 0; j < 6; ++j) a[i][j] -= f * a[k][j], b[i][j] -= f * b[k][j];
		}
	}
	for (std::size_t i = 0; i < 6; ++i)
		for (std::size_t j = 0; j < 6; ++j) b[i][j] /= a[i][i];
	return b;
}

/// Whether the Cholesky factorisation exists.
bool isPositive(Matrix a)
{
	for (std::size_t k = 0; k < 6; ++k)
	{
		if (!(a[k][k] > 0)) return false;
		for (std::size_t i = k + 1; i < 6; ++i)
			for (std::size_t j = k + 1; j < 6; ++j) a[i][j] -= a[i][k] * a[k][j] / a[k][k];
	}
	return true;
}

/// Whether coupling and contact in series are below `share` of the bounds in every direction. With u in units of the bounds, the force is
/// that of the least energy g |u - x|^2 + x C x, which is g (g + C)^-1 C u.
bool seriesStaysBelow(double share, double factor, const Matrix& contactInBounds)
{
	Matrix sum = contactInBounds, left;
	for (std::size_t i = 0; i < 6; ++i) sum[i][i] += factor;
	const Matrix series = divided(sum, contactInBounds);
	for (std::size_t i = 0; i < 6; ++i)
		for (std::size_t j = 0; j < 6; ++j) left[i][j] = (i == j ? share : 0) - 0.5 * factor * (series[i][j] + series[j][i]);
	return isPositive(left);
}

struct RandomContact
{
	ist::SymmetricMatrix6 C;
	Matrix inBounds{};
	RandomContact(std::mt19937& random, int rank, double size)
	{
		std::normal_distribution<double> normal;
		for (int k = 0; k < rank; ++k)
		{
			double g[6];
			for (double& x : g) x = normal(random);
			for (int i = 0; i < 6; ++i)
				for (int j = 0; j < 6; ++j)
				{
					const double entry = size * g[i] * g[j];
					inBounds[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] += entry;
					if (j >= i) C(i, j) += entry * std::sqrt(bound(i) * bound(j));
				}
		}
	}
};
}  // namespace

TEST(AdaptiveCoupling, SeriesWithTheContactReachesTheBoundsAndNeverPassesThem)
{
	std::mt19937 random(1);
	int atTheBound = 0;
	for (const double size : {1e-3, 0.1, 1.0, 10.0, 1e4, 1e8})
		for (int rank = 0; rank <= 6; ++rank)
			for (int i = 0; i < 20; ++i)
			{
				const RandomContact contact(random, rank, size);
				AdaptiveCoupling coupling(bounds(8));
				coupling.adapt(contact.C, false, 0, 0, {}, {}, kTick);
				EXPECT_GE(coupling.factor(), 1);
				EXPECT_LE(coupling.factor(), 8);
				const double rounding = 1e-9 + 1e-14 * size;  // rounding of the elimination above
				EXPECT_TRUE(seriesStaysBelow(1 + rounding, coupling.factor(), contact.inBounds)) << size << ' ' << rank;
				EXPECT_NEAR(coupling.gains().stiffness, 1000 * coupling.factor(), 1e-9);
				EXPECT_NEAR(coupling.gains().angularStiffness, 2 * coupling.factor(), 1e-12);
				if (!(coupling.factor() < 8) || size > 1e4) continue;
				++atTheBound;
				EXPECT_FALSE(seriesStaysBelow(1 - 1e-4, coupling.factor(), contact.inBounds)) << size << ' ' << rank;
			}
	EXPECT_GT(atTheBound, 200);
}

TEST(AdaptiveCoupling, ADeviceOfThreeFreedomsIsBoundByItsForcesAlone)
{
	CouplingGains gains = bounds(8);
	gains.angularStiffness = 0;
	ist::SymmetricMatrix6 contact;
	contact(0, 0) = 2000;
	contact(4, 4) = 1e9;
	AdaptiveCoupling coupling(gains);
	coupling.adapt(contact, false, 0, 0, {}, {}, kTick);
	EXPECT_NEAR(coupling.factor(), 2, 1e-12);  // c = 2
	EXPECT_EQ(coupling.gains().angularStiffness, 0);
}

TEST(AdaptiveCoupling, MassDampersAndFrictionResistWithinATick)
{
	ist::SymmetricMatrix6 none, resistance, stiffness, damping;
	AdaptiveCoupling heavy(bounds(8)), light(bounds(8)), stuck(bounds(8)), damped(bounds(8));
	heavy.adapt(none, false, 0.1, 1e-12, {}, {}, kTick);
	EXPECT_NEAR(heavy.factor(), 400.0 / 399, 1e-9);  // 4 M / h^2 = 400 bounds
	light.adapt(none, false, 1e-5, 1e-12, {}, {}, kTick);
	EXPECT_EQ(light.factor(), 8);
	stuck.adapt(none, true, 0, 0, {}, {}, kTick);
	EXPECT_EQ(stuck.factor(), 1);
	damping(1, 1) = 1;
	addResistance(resistance, stiffness, damping, {}, kTick);
	damped.adapt(resistance, false, 0, 0, {}, {}, kTick);
	EXPECT_NEAR(damped.factor(), 2, 1e-12);  // 2 D / h = 2 bounds
}

// Oracle: force and moment of a spring at the arm, found by displacing the body.
TEST(AdaptiveCoupling, ResistanceIsMovedToTheToolsOrigin)
{
	std::mt19937 random(2);
	std::uniform_real_distribution<double> any(-1, 1);
	for (int trial = 0; trial < 50; ++trial)
	{
		const RandomContact contact(random, 4, 1);
		const ist::Vec3 arm{any(random), any(random), any(random)};
		const ist::Twist moved{{any(random), any(random), any(random)}, {any(random), any(random), any(random)}};
		ist::SymmetricMatrix6 sum, none;
		addResistance(sum, contact.C, none, arm, kTick);
		const auto times = [](const ist::SymmetricMatrix6& K, const ist::Twist& t) {
			const double x[6] = {t.linear.x, t.linear.y, t.linear.z, t.angular.x, t.angular.y, t.angular.z};
			double y[6] = {};
			for (int i = 0; i < 6; ++i)
				for (int j = 0; j < 6; ++j) y[i] += K(i, j) * x[j];
			return ist::Wrench{{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
		};
		const ist::Wrench atArm = times(contact.C, {moved.linear + cross(moved.angular, arm), moved.angular});
		const ist::Wrench found = times(sum, moved);
		EXPECT_LT(distance(found.force, atArm.force), 1e-9 * norm(atArm.force));
		EXPECT_LT(distance(found.torque, atArm.torque + cross(arm, atArm.force)), 1e-9 * (norm(atArm.torque) + norm(atArm.force)));
	}
}

namespace
{
/// Work of a coupling on its two ends. A stretch at constant stiffness moves along one potential, and a sudden change of the stiffness does
/// no work.
struct Audit
{
	double stretch = 0, done = 0;
	static double potential(double G, double x, double limit)
	{
		const double pull = G * std::fabs(x);
		return pull < limit ? 0.5 * pull * std::fabs(x) : limit * (std::fabs(x) - 0.5 * limit / G);
	}
	void go(double to, double G, double limit)
	{
		done += potential(G, stretch, limit) - potential(G, to, limit);
		stretch = to;
	}
};
}  // namespace

// Motions of the ends and changes of the contact can never extract more energy than was put in. The deliberate sequence tries to: it is
// stiff while the stretch grows and soft while it falls.
TEST(AdaptiveCoupling, NoHistoryOfContactsMakesEnergy)
{
	std::mt19937 random(3);
	std::uniform_real_distribution<double> place(-0.02, 0.02), size(-2, 2);
	for (const double limit : {kInf, 3.0})
		for (const bool onPurpose : {false, true})
		{
			CouplingGains gains = bounds(8);
			gains.maxForce = gains.maxTorque = limit;
			AdaptiveCoupling coupling(gains);
			Audit audit, withoutTank;
			double most = -kInf, mostWithout = -kInf, mostInStore = -kInf, lowest = kInf, highest = 0;
			for (int i = 0; i < 4000; ++i)
			{
				const double to = onPurpose ? (i / 100 % 2 ? 0 : 0.02) : place(random);
				const bool grows = std::fabs(to) > std::fabs(audit.stretch);
				ist::SymmetricMatrix6 contact;
				contact(0, 0) = onPurpose ? (grows ? 1e6 : 0) : 1000 * std::pow(10, size(random));
				const ist::Pose hand{{}, {audit.stretch, 0, 0}};
				coupling.adapt(contact, false, 0, 0, hand, {}, kTick);
				const double G = coupling.gains().stiffness, c = contact(0, 0) / 1000;
				mostInStore = std::max(mostInStore, audit.done + Audit::potential(G, audit.stretch, limit) + coupling.tank());
				audit.go(to, G, limit);
				withoutTank.go(to, c > 1 ? 1000 * std::min(8.0, c / (c - 1)) : 8000, limit);
				most = std::max(most, audit.done);
				mostWithout = std::max(mostWithout, withoutTank.done);
				lowest = std::min(lowest, coupling.factor());
				highest = std::max(highest, coupling.factor());
			}
			EXPECT_LT(most, 1e-12) << limit << onPurpose;
			EXPECT_LT(mostInStore, 1e-12) << "spring and tank hold no more than was put in: " << limit << onPurpose;
			EXPECT_GT(mostWithout, 5e-3) << limit << onPurpose;
			EXPECT_LT(lowest, 1.1);
			EXPECT_GT(highest, 1.5);
		}
}

// A hand that presses slowly and withdraws meets the same coupling on both ways, because the energy from softening pays for stiffening.
TEST(AdaptiveCoupling, PressingAndReleasingIsPaidForByTheTank)
{
	AdaptiveCoupling coupling(bounds(8));
	const auto at = [](double x) {
		ist::SymmetricMatrix6 contact;
		contact(0, 0) = 1e6 * x;
		return contact;
	};
	double in = 0;
	for (int i = 0; i <= 4000; ++i)
	{
		const double depth = 2e-3 * (i <= 2000 ? i : 4000 - i) / 2000;
		coupling.adapt(at(depth), false, 0, 0, {{}, {depth, 0, 0}}, {}, kTick);
		if (i == 1500) in = coupling.factor();
		if (i == 2500)
		{
			EXPECT_NEAR(coupling.factor(), in, 0.03 * in);
		}
	}
	EXPECT_GT(in, 2);
	EXPECT_GT(coupling.factor(), 5);
}

TEST(AdaptiveCoupling, WithoutLeaveItStaysAsItIs)
{
	AdaptiveCoupling coupling(bounds(1));
	ist::SymmetricMatrix6 contact;
	coupling.adapt(contact, false, 0, 0, {}, {}, kTick);
	EXPECT_FALSE(coupling.adapts());
	EXPECT_EQ(coupling.gains().stiffness, 1000);
	AdaptiveCoupling odd(bounds(std::numeric_limits<double>::quiet_NaN()));
	EXPECT_FALSE(odd.adapts());
	AdaptiveCoupling free(bounds(4));
	contact(2, 2) = std::numeric_limits<double>::quiet_NaN();
	free.adapt(contact, false, 0, 0, {}, {}, kTick);
	EXPECT_EQ(free.factor(), 1);
}
