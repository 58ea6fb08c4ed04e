// SPDX-License-Identifier: Zlib
#include "demos/browser/view/AffordableQuality.h"
#include "demos/browser/base/DemoSolid.h"
#include "demos/browser/render/OffscreenContext.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>

using namespace browser;

namespace
{
/// A machine that takes so long for a picture of all pixels [s], for all of its spheres, once more where they cast shadows, and for the
/// rest.
struct Machine
{
	double forPixels, forSpheres, forTheRest;
	double picture(const RenderQuality& q) const
	{
		const double spheres = std::pow(3 * q.leastRadius / q.pixels, -2) * (q.shadowTaps > 0 ? 1 : 0.5);
		return forTheRest + forPixels * q.pixels * q.pixels + forSpheres * spheres;
	}
};

struct Pictures
{
	double last = 0;  // [s]
	int slow = 0;     // pictures of more than 1/12 s
	int changes = 0;
};
Pictures run(AffordableQuality& affordable, const Machine& machine, int pictures)
{
	Pictures all;
	for (int i = 0; i < pictures; ++i)
	{
		const RenderQuality before = affordable.quality();
		all.last = machine.picture(before);
		all.slow += all.last > 1.0 / 12;
		affordable.took(all.last);
		const RenderQuality after = affordable.quality();
		all.changes += after.pixels != before.pixels || after.shadowTaps != before.shadowTaps || after.leastRadius != before.leastRadius;
	}
	return all;
}

/// Of all threads of this program: a driver that draws in software has some [s].
double processorTime() { return double(std::clock()) / CLOCKS_PER_SEC; }
}  // namespace

TEST(AffordableQuality, GivesUpNothingWhereNothingIsSlow)
{
	AffordableQuality affordable;
	EXPECT_EQ(run(affordable, {0.02, 0.001, 0.001}, 1000).changes, 0);
	EXPECT_EQ(affordable.quality().pixels, 1);
	EXPECT_GT(affordable.quality().shadowTaps, 0);
	// Now and then a picture is late: a demo is loaded, another program has the processor.
	for (int i = 0; i < 100; ++i) affordable.took(i % 5 ? 0.02 : 2);
	EXPECT_EQ(affordable.quality().pixels, 1);
}

TEST(AffordableQuality, IsSoonFastEnoughAndStaysSo)
{
	for (const Machine& machine : {Machine{0.15, 0, 0.005}, Machine{0.3, 0, 0.02}, Machine{0.05, 0.5, 0.02}, Machine{0.4, 1, 0.01}})
	{
		AffordableQuality affordable;
		EXPECT_LE(run(affordable, machine, 20).slow, 12);
		const Pictures after = run(affordable, machine, 20000);
		EXPECT_LE(after.last, 1.0 / 12);
		EXPECT_EQ(after.slow + after.changes, 0);
	}
}

// Where a rung between fast and too slow is missing: taken back, it is given up again, ever less often, and at most once a minute in the
// end.
TEST(AffordableQuality, TriesEverLessOftenWhatProvedTooSlow)
{
	for (const Machine& machine : {Machine{0, 0.3, 0.005}, Machine{0.01, 0.1, 0.005}})
	{
		AffordableQuality affordable;
		EXPECT_GT(run(affordable, machine, 1000).slow, 2);
		run(affordable, machine, 20000);
		EXPECT_LE(run(affordable, machine, 38400).slow, 2 * 10);
		// A lighter demo has all of it back soon, though.
		run(affordable, {0.01, 0.001, 0.001}, 4200);
		EXPECT_EQ(affordable.quality().pixels, 1);
		EXPECT_GT(affordable.quality().shadowTaps, 0);
		// That one was not to blame: the next heavy one is asked as often as the first.
		run(affordable, {0.4, 1, 0.01}, 100);
		run(affordable, {0.01, 0.001, 0.001}, 2000);
		EXPECT_EQ(affordable.quality().pixels, 1);
	}
}

TEST(AffordableQuality, TakesBackWhatItGaveUp)
{
	AffordableQuality affordable;
	run(affordable, {0.4, 1, 0.01}, 100);
	EXPECT_LT(affordable.quality().pixels, 0.6);
	run(affordable, {0.01, 0.001, 0.001}, 2000);
	EXPECT_EQ(affordable.quality().pixels, 1);
	EXPECT_GT(affordable.quality().shadowTaps, 0);
}

TEST(AffordableQuality, EndsWhereNothingHelps)
{
	AffordableQuality affordable;
	EXPECT_LE(run(affordable, {0, 0, 1}, 1000).changes, 8);
	EXPECT_GT(affordable.quality().pixels, 0);
}

// What each rung costs where everything is drawn by the processor.
TEST(AffordableQuality, OfAHundredThousandBallsIsReported)
{
	auto context = OffscreenContext::make();
	if (!context) GTEST_SKIP() << context.error().message;
	auto renderer = Renderer::make();
	ASSERT_TRUE(renderer) << renderer.error().message;
	DemoOptions options;
	options.cache = TREE_FOLDER;
	SolidPtr knot;
	const auto failed = makeSolid(knot, "knot", knotMesh(1), 10000, options);
	ASSERT_FALSE(failed) << failed->message;
	DrawList list;
	DrawChoice choice;
	choice.spheres = true;
	for (int i = 0; i < 10; ++i)
	{
		ist::Pose X;
		X.translation = {1.1 * (i % 4), 0.2, 1.1 * (i / 4)};
		knot->spheres.draw(choice, X, list);
	}
	Camera camera;
	camera.set({{1.6, 0, 1.1}, 5, 0.5, 0.6});
	PictureTarget target(1280, 800);
	std::printf("  %s\n", renderer.value()->device().c_str());
	AffordableQuality affordable;
	size_t before = 100001;
	for (bool more = true; more;)
	{
		const RenderQuality quality = affordable.quality();
		double times[3];
		for (double& time : times)
		{
			const double start = processorTime();
			renderer.value()->beginPicture();
			renderer.value()->draw(list, camera, target.frame(), {0, 1280, 800}, quality);
			target.read();
			time = processorTime() - start;
		}
		const size_t balls = renderer.value()->cost().ballsDrawn;
		std::printf("  %4.0f x %3.0f pixels%s, %6zu balls: %4.0f ms of the processor\n", 1280 * quality.pixels, 800 * quality.pixels,
			quality.shadowTaps > 0 ? ", shadows" : "         ", balls, 1e3 * *std::min_element(times + 1, times + 3));
		EXPECT_LE(balls, before);
		before = balls;
		affordable.took(1);
		affordable.took(1);
		more = affordable.quality().pixels < quality.pixels || affordable.quality().shadowTaps < quality.shadowTaps;
	}
	EXPECT_LT(before, 20000u);
}
