// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/StableTimeStep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace ist;

namespace
{
/// Springs of all scales, with and without damping.
std::vector<ContactSpring> springs()
{
	std::mt19937_64 random(4);
	std::uniform_real_distribution<double> decade(-3, 3);
	std::vector<ContactSpring> all;
	for (int i = 0; i < 40; ++i)
	{
		ContactSpring spring{std::pow(10, 3 + decade(random)), std::pow(10, decade(random) / 2), 0};
		if (i % 2) spring.damping = std::pow(10, decade(random) / 3) * std::sqrt(spring.stiffness * spring.mass);
		all.push_back(spring);
	}
	return all;
}

/// Whether explicit steps that start at a displacement of 1 stay bounded.
bool explicitStepsStay(const ContactSpring& spring, double h)
{
	double x = 1, v = 0;
	for (int i = 0; i < 4000; ++i)
	{
		v -= h * (spring.stiffness * x + spring.damping * v) / spring.mass;
		x += h * v;
		if (!(std::fabs(x) < 1e6)) return false;
	}
	return true;
}

/// Rebound speed of a body that arrives at 1 m/s and touches after `phase` of a step. It takes backward Euler steps until it leaves.
double bounceInImplicitSteps(const ContactSpring& spring, double h, double phase)
{
	double x = phase * h, v = -1;  // contact is below x = 0
	for (int i = 0; i < 10000000; ++i)
	{
		const double K = x < 0 ? spring.stiffness : 0;
		v = (v - h * K * x / spring.mass) / (1 + h * h * K / spring.mass);
		x += h * v;
		if (x > 0 && v > 0) break;
	}
	return v;
}
}  // namespace

TEST(StableTimeStep, ExplicitStepsDivergeJustBeyondTheirLimit)
{
	for (const ContactSpring& spring : springs())
	{
		const double h = longestExplicitStep(spring);
		EXPECT_NEAR(h * h * spring.stiffness / spring.mass + 2 * h * spring.damping / spring.mass, 4, 1e-9);
		EXPECT_TRUE(explicitStepsStay(spring, 0.98 * h)) << spring.stiffness << " " << spring.mass << " " << spring.damping;
		EXPECT_FALSE(explicitStepsStay(spring, 1.02 * h)) << spring.stiffness << " " << spring.mass << " " << spring.damping;
	}
}

TEST(StableTimeStep, ImplicitStepsLoseTheSpeedThatIsForetold)
{
	for (ContactSpring spring : springs())
	{
		spring.damping = 0;
		for (const double hw : {0.003, 0.02, 0.1})
			for (const double phase : {0.1, 0.5, 0.9})
			{
				const double h = hw / std::sqrt(spring.stiffness / spring.mass);
				// The effect of the position within the first step is of second order.
				EXPECT_NEAR(implicitRestitution(spring, h), bounceInImplicitSteps(spring, h, phase), 1e-4 + hw * hw);
			}
		for (const double error : {0.01, 0.05, 0.15})
		{
			const double h = longestStepForRestitution(spring, error);
			EXPECT_NEAR(implicitRestitution(spring, h), 1 - error, 1e-12);
			// The model ignores where within a step the contact begins. At the longest of these steps this changes the loss by about
			// 15 %.
			EXPECT_NEAR(bounceInImplicitSteps(spring, h, 0.4), 1 - error, 0.15 * error);
		}
	}
}

TEST(StableTimeStep, NothingTravelsMoreThanAQuarterOfWhatIsThin)
{
	InnerSphereTree plate;
	plate.volume = 2 * 3 * 0.01;
	plate.area = 2 * (2 * 3 + 2 * 0.01 + 3 * 0.01);
	EXPECT_NEAR(thicknessOf(plate), 0.01, 1e-4);
	EXPECT_NEAR(longestStepForThickness(5, 0.01) * 5, 0.0025, 1e-15);
	EXPECT_EQ(longestStepForThickness(0, 0.01), std::numeric_limits<double>::infinity());
	EXPECT_EQ(thicknessOf(InnerSphereTree()), std::numeric_limits<double>::infinity());
}

TEST(StableTimeStep, RoundingIsHalfTheSpacingOfNumbers)
{
	EXPECT_EQ(placeRounding(1, false), std::ldexp(1, -24));
	EXPECT_EQ(placeRounding(10000, false), std::ldexp(1, 13 - 24));
	EXPECT_EQ(placeRounding(-10000, true), std::ldexp(1, 13 - 53));
	std::mt19937_64 random(8);
	std::uniform_real_distribution<double> u(1, 1e5);
	for (int i = 0; i < 1000; ++i)
	{
		const double x = u(random);
		EXPECT_LE(std::fabs(double(float(x)) - x), placeRounding(x, false) * (1 + 1e-6));
	}
}
