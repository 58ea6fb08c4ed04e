// SPDX-License-Identifier: Zlib
#include "demos/browser/drawing/Palette.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace browser;

namespace
{
double linear(double srgb) { return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4); }

/// As seen without one kind of cone: the matrices of Machado, Oliveira and Fernandes (2009) at full severity, on linear light.
using Cones = const double[3][3];
Colour seenBy(Cones& m, const Colour& c)
{
	const double rgb[] = {linear(c.r), linear(c.g), linear(c.b)};
	double out[3];
	for (int i = 0; i < 3; ++i) out[i] = m[i][0] * rgb[0] + m[i][1] * rgb[1] + m[i][2] * rgb[2];
	return {float(out[0]), float(out[1]), float(out[2])};
}

constexpr double kNobody[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr double kProtan[3][3] = {{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}};
constexpr double kDeutan[3][3] = {{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}};
constexpr double kTritan[3][3] = {{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}};

double apart(const Colour& a, const Colour& b) { return std::hypot(double(a.r - b.r), double(a.g - b.g), double(a.b - b.b)); }
}  // namespace

TEST(Palette, BodiesDifferForEveryEye)
{
	for (Cones* const eye : {&kNobody, &kProtan, &kDeutan, &kTritan})
		for (int i = 0; i < kBodyColours; ++i)
			for (int j = 0; j < i; ++j)
				EXPECT_GT(apart(seenBy(*eye, bodyColour(i)), seenBy(*eye, bodyColour(j))), 0.06) << i << " and " << j;
}

TEST(Palette, RampsGrowLighterAllTheWay)
{
	for (const auto ramp : {levelColour, pressureColour})
	{
		double before = -1;
		for (int i = 0; i <= 200; ++i)
		{
			const double now = lightness(ramp(i / 200.0));
			EXPECT_GT(now, before) << i;
			before = now;
		}
		EXPECT_GT(lightness(ramp(1)) - lightness(ramp(0)), 60);
	}
}

TEST(Palette, LevelsDifferForEveryEyeUpToTheSeventh)
{
	for (Cones* const eye : {&kNobody, &kProtan, &kDeutan, &kTritan})
		for (int i = 0; i <= 7; ++i)
			for (int j = 0; j < i; ++j)
				EXPECT_GT(apart(seenBy(*eye, shadeColour(levelShade(i))), seenBy(*eye, shadeColour(levelShade(j)))), 0.035)
					<< i << " and " << j;
	EXPECT_EQ(levelShade(40), levelShade(8));
}

TEST(Palette, EndsHoldBeyondTheRamp)
{
	EXPECT_EQ(apart(levelColour(-3), levelColour(0)), 0);
	EXPECT_EQ(apart(pressureColour(7), pressureColour(1)), 0);
	EXPECT_EQ(apart(bodyColour(-1), bodyColour(kBodyColours - 1)), 0);
}
