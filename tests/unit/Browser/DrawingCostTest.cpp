// SPDX-License-Identifier: Zlib
#include "demos/browser/catalog/DemoCatalog.h"
#include "demos/browser/render/Renderer.h"
#include "demos/browser/render/Stopwatch.h"
#include "demos/browser/view/SceneView.h"
#include "tests/unit/Browser/NullGl.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

// OpenGL does nothing here (NullGl.cpp), so that what a picture costs is what our own code costs: lists, culling, instances, and the calls.
using namespace browser;

namespace
{
constexpr PixelArea kArea{0, 1280, 800};

std::shared_ptr<const SpheresModel> cloud(size_t count, double largest)
{
	auto model = std::make_shared<SpheresModel>();
	std::mt19937_64 random(count);
	std::uniform_real_distribution<float> u(-1, 1);
	for (size_t i = 0; i < count; ++i)
		model->spheres.push_back(
			{u(random), u(random), u(random), float(largest) * (1 - 0.6f * float(i) / float(count)), float(i) / float(count)});
	return model;
}

/// So many bodies of so many balls, all of which are seen.
DrawList bodies(size_t count, size_t balls)
{
	DrawList list;
	for (size_t i = 0; i < count; ++i)
	{
		ist::Pose X;
		X.translation = {2.5 * double(i % 10), 2.5 * double(i / 10), 0};
		list.spheres.push_back({cloud(balls, 0.1), X, balls, 1});
	}
	return list;
}

Camera cameraAt(double distance)
{
	Camera camera;
	camera.set({{11, 11, 0}, distance, 0.3, 0.2});
	return camera;
}

/// Median and 99th percentile of our own time of a picture [us].
struct Times
{
	double median = 0, most = 0;
};
Times timesOf(int pictures, const std::function<void(int)>& draw)
{
	std::vector<double> times;
	for (int i = 0; i < pictures; ++i)
	{
		double took = 0;
		{
			const Stopwatch watch(took);
			draw(i);
		}
		times.push_back(took);
	}
	std::sort(times.begin(), times.end());
	return {times[times.size() / 2], times[times.size() * 99 / 100]};
}

void print(const char* what, const Times& t)
{
	std::printf("  %-58s %8.3f ms, 99th percentile %8.3f ms\n", what, 1e-3 * t.median, 1e-3 * t.most);
}
}  // namespace

TEST(DrawingCost, AHundredThousandBallsGoInOneInstancedCall)
{
	auto renderer = Renderer::make();
	ASSERT_TRUE(renderer);
	for (const size_t count : {1u, 20u, 100u})
	{
		DrawList list = bodies(count, 100000 / count);
		list.shadows = false;
		const Camera camera = cameraAt(40);
		NullGl& gl = NullGl::get();
		renderer.value()->draw(list, camera, 0, kArea, {});
		for (const int picture : {1, 2})
		{
			gl = {};
			for (DrawnSpheres& s : list.spheres) s.X_WM.translation.y += 0.01;
			renderer.value()->beginPicture();
			renderer.value()->draw(list, camera, 0, kArea, {});
			EXPECT_EQ(gl.largeCalls, 1u) << count << " bodies, picture " << picture;
			EXPECT_EQ(gl.mostInstances, 100000u);
			EXPECT_EQ(renderer.value()->cost().ballsDrawn, 100000u);
			EXPECT_EQ(renderer.value()->cost().drawCalls, gl.drawCalls);
			// The balls lie on the graphics card; poses alone go there, 48 bytes each.
			EXPECT_LE(gl.uploadedBytes, 48 * count);
		}
		// A second call draws their shadows.
		list.shadows = true;
		gl = {};
		renderer.value()->draw(list, camera, 0, kArea, {});
		EXPECT_EQ(gl.largeCalls, 2u);
	}
}

TEST(DrawingCost, OfAHundredThousandBallsIsReported)
{
	auto made = Renderer::make();
	ASSERT_TRUE(made);
	Renderer& renderer = *made.value();
	for (const size_t count : {1u, 100u})
	{
		DrawList list = bodies(count, 100000 / count);
		std::printf("  %zu bodies of %zu balls\n", count, 100000 / count);
		const auto draw = [&](double distance) {
			for (DrawnSpheres& s : list.spheres) s.X_WM.translation.y += 1e-4;
			renderer.beginPicture();
			renderer.draw(list, cameraAt(distance), 0, kArea, {});
		};
		print("    they move", timesOf(300, [&](int) { draw(40); }));
		print("    and the camera goes from near to far", timesOf(300, [&](int i) { draw(40 * std::pow(1.02, i)); }));
		EXPECT_LT(renderer.cost().ballsDrawn, 60000u);
		const DrawList other = bodies(count, 100000 / count);
		print("    other ones in each picture, all of them to be uploaded",
			timesOf(60, [&](int i) { renderer.draw(i % 2 ? list : other, cameraAt(40), 0, kArea, {}); }));
	}
}

TEST(DrawingCost, OfDemosIsReported)
{
	auto made = Renderer::make();
	ASSERT_TRUE(made);
	Renderer& renderer = *made.value();
	ScenePainter painter;
	for (const char* name : {"stack", "shapes", "energy", "packing"})
	{
		const auto demo = findDemo(name)->make();
		DemoOptions options;
		options.cache = TREE_FOLDER;
		ASSERT_FALSE(demo->prepare(options));
		ASSERT_FALSE(demo->restart());
		for (int i = 0; i < 200; ++i) demo->step(demo->stepSize());
		Camera camera;
		camera.set(demo->viewpoint());
		for (const char* shown : {"", "spheres", "sphere-levels", "spheres,levels,frames,boxes", "lenses"})
		{
			DrawChoice choice;
			ASSERT_EQ(applyChoices(shown, choice), "");
			const std::string what = std::string("  ") + name + (*shown ? " with " : "") + shown;
			print(
				what.c_str(), timesOf(100, [&](int) { painter.paint(sceneViews(*demo, kArea), choice, camera, renderer, 0, {}, false); }));
			EXPECT_GT(renderer.cost().ownMicroseconds, 0);
		}
	}
}
