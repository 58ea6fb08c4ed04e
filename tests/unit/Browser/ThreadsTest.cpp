// SPDX-License-Identifier: Zlib
#include "demos/browser/base/Threads.h"
#include "tests/unit/ClosedMesh.h"
#include "tests/unit/SolidAngleWinding.h"

#include <gtest/gtest.h>

#include <random>

using namespace ist;

namespace
{
constexpr double kPi = 3.14159265358979323846, kClearance = 5e-4, kWidth = 0.07, kHeight = 0.045;
constexpr browser::Thread kThread;

/// Share of some points of the screw's thread that lie in the nut, when the screw is turned by `turn` about +y and raised by `rise`.
double shareInside(double turn, double rise)
{
	static const Mesh rod = browser::screw(kThread, 0.12, 0.03, 0.01), held = browser::nut(kThread, kClearance, kWidth, kHeight);
	std::mt19937_64 random(30);
	std::uniform_int_distribution<size_t> any(0, rod.vertices.size() - 1);
	int inside = 0, looked = 0;
	while (looked < 60)
	{
		const Vec3 p = rod.vertices[any(random)];
		const Vec3 q{p.x * std::cos(turn) + p.z * std::sin(turn), p.y + rise, p.z * std::cos(turn) - p.x * std::sin(turn)};
		if (p.y >= 0 || std::fabs(q.y) > 0.45 * kHeight) continue;
		++looked;
		inside += windingNumber(held, q) > 0.5;
	}
	return double(inside) / looked;
}
}  // namespace

// Int of a circle's area over whole waves: pi (R^2 + depth^2 / 2); n-gons in place of circles lose sin(2 pi / n) / (2 pi / n).
TEST(Threads, ScrewAndNutHaveTheVolumesOfTheirSections)
{
	const double lost = std::sin(2 * kPi / 96) / (2 * kPi / 96), wave = 0.5 * kThread.depth * kThread.depth;
	const Mesh rod = browser::screw(kThread, 4 * kThread.lead, 0.03, 0.01), held = browser::nut(kThread, kClearance, kWidth, kThread.lead);
	EXPECT_TRUE(isClosed(rod));
	EXPECT_TRUE(isClosed(held));
	const double rodVolume = lost * kPi * ((kThread.radius * kThread.radius + wave) * 4 * kThread.lead + 0.03 * 0.03 * 0.01);
	EXPECT_NEAR(massProperties(rod).volume, rodVolume, 0.002 * rodVolume);
	const double hole = kThread.radius + kClearance,
				 nutVolume = (kWidth * kWidth * std::sqrt(3) / 2 - lost * kPi * (hole * hole + wave)) * kThread.lead;
	EXPECT_NEAR(massProperties(held).volume, nutVolume, 0.005 * nutVolume);
}

TEST(Threads, FitAtEveryTurnRightHandedOnly)
{
	for (const double turn : {0.0, 0.7, 2.0, -4.0, 9.0})
	{
		const double rise = kThread.lead * (2 + turn / (2 * kPi));
		EXPECT_EQ(shareInside(turn, rise), 0) << turn;
		EXPECT_GT(shareInside(turn, rise + 0.5 * kThread.lead), 0.2) << turn;
	}
	EXPECT_GT(shareInside(1.5, kThread.lead * (2 - 1.5 / (2 * kPi))), 0.2);
}
