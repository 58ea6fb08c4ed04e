// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Camera.h"

#include <gtest/gtest.h>

#include <random>

using namespace browser;
using ist::Vec3;

namespace
{
Camera randomCamera(std::mt19937_64& random, double far)
{
	std::uniform_real_distribution<double> u(-1, 1);
	Viewpoint view;
	view.target = {far * u(random), far * u(random), far * u(random)};
	view.distance = 2 + u(random);
	view.yaw = 3 * u(random);
	view.pitch = 1.4 * u(random);
	Camera camera;
	camera.set(view);
	return camera;
}
}  // namespace

TEST(Camera, SeesAPointWhereItsRayGoes)
{
	std::mt19937_64 random(3);
	std::uniform_real_distribution<double> u(0, 1);
	for (int i = 0; i < 200; ++i)
	{
		const Camera camera = randomCamera(random, i == 0 ? 1000 : 3);
		const double x = u(random), y = u(random), aspect = 0.5 + 2 * u(random), away = 0.5 + 4 * u(random);
		const auto seen = camera.project(camera.eye() + away * camera.ray(x, y, aspect), aspect);
		ASSERT_TRUE(seen);
		EXPECT_NEAR((*seen)[0], x, 1e-6);
		EXPECT_NEAR((*seen)[1], y, 1e-6);
		EXPECT_FALSE(camera.project(camera.eye() - away * camera.ray(x, y, aspect), aspect)) << "behind the eye";
	}
}

// What OpenGL makes of its matrices is what `project` says.
TEST(Camera, AgreesWithItsMatrices)
{
	std::mt19937_64 random(4);
	for (int i = 0; i < 100; ++i)
	{
		const Camera camera = randomCamera(random, 2);
		const double aspect = 1.7;
		const Vec3 p = camera.eye() + 2.5 * camera.ray(0.3, 0.8, aspect);
		const Matrix4 both = camera.projection(aspect) * camera.view();
		double clip[4];
		for (int r = 0; r < 4; ++r)
			clip[r] = double(both(r, 0)) * p.x + double(both(r, 1)) * p.y + double(both(r, 2)) * p.z + double(both(r, 3));
		EXPECT_NEAR(0.5 + 0.5 * clip[0] / clip[3], 0.3, 1e-4);
		EXPECT_NEAR(0.5 - 0.5 * clip[1] / clip[3], 0.8, 1e-4);
		const Matrix4 back = inversePerspective(camera.projection(aspect)) * camera.projection(aspect);
		for (int r = 0; r < 4; ++r)
			for (int c = 0; c < 4; ++c) EXPECT_NEAR(double(back(r, c)), r == c, 1e-5);
	}
}

TEST(Camera, KeepsThePointUnderTheMouseWhilePanning)
{
	std::mt19937_64 random(5);
	Camera camera = randomCamera(random, 1);
	const Vec3 p = camera.viewpoint().target;
	camera.pan(0.2, -0.1, 1);
	const auto seen = camera.project(p, 1);
	ASSERT_TRUE(seen);
	EXPECT_NEAR((*seen)[0], 0.7, 1e-9);
	EXPECT_NEAR((*seen)[1], 0.4, 1e-9);
}

TEST(Camera, SeesAsMuchFromLeftToRightInANarrowPicture)
{
	std::mt19937_64 random(6);
	for (int i = 0; i < 20; ++i)
	{
		const Camera camera = randomCamera(random, 3);
		for (const double narrow : {1.2, 0.8, 0.3})
		{
			const Vec3 edge = camera.eye() + 2 * camera.ray(0.05, 0.5, Camera::kFullAspect);
			EXPECT_NEAR((*camera.project(edge, narrow))[0], 0.05, 1e-9);
			EXPECT_GT(camera.heightAt(1, narrow), camera.heightAt(1, 2));
		}
		EXPECT_EQ(camera.heightAt(1, 1.5), camera.heightAt(1, 3));
	}
}

TEST(Camera, NeverTurnsOverAndNeverReachesItsTarget)
{
	Camera camera;
	camera.set({{1, 2, 3}, 1, 0, 0});
	for (int i = 0; i < 100; ++i) camera.turn(0.1, 0.5), camera.zoom(50);
	EXPECT_LT(camera.viewpoint().pitch, 1.5708);
	EXPECT_GT(camera.viewpoint().distance, 0);
	EXPECT_TRUE(ist::isFinite(camera.eye()));
}
