// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Renderer.h"
#include "demos/browser/render/OffscreenContext.h"
#include "demos/browser/view/Photographer.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/EachDemo.h"

#include <cmath>
#include <cstdlib>
#include <random>

using namespace browser;

namespace
{
constexpr int kWidth = 320, kHeight = 180;

#define NEEDS(made) \
	if (!made) GTEST_SKIP() << made.error().message

/// Middle of what differs from the upper left corner, and its share of the picture.
struct Seen
{
	double x = 0, y = 0, share = 0;
};
Seen look(const Picture& p, const Picture& empty)
{
	Seen seen;
	double count = 0;
	for (int y = 0; y < p.height; ++y)
		for (int x = 0; x < p.width; ++x)
		{
			int off = 0;
			for (int c = 0; c < 3; ++c)
				off += std::abs(p.pixels[size_t(3 * (y * p.width + x) + c)] - empty.pixels[size_t(3 * (y * p.width + x) + c)]);
			if (off < 24) continue;
			seen.x += x + 0.5, seen.y += y + 0.5, ++count;
		}
	return {seen.x / count / p.width, seen.y / count / p.height, count / (p.width * p.height)};
}

/// A cloud of balls as a model.
std::shared_ptr<const SpheresModel> cloud(size_t count, double size, double largest)
{
	auto model = std::make_shared<SpheresModel>();
	std::mt19937_64 random(7);
	std::uniform_real_distribution<float> u(-1, 1);
	for (size_t i = 0; i < count; ++i)
	{
		const float share = float(i) / float(count);
		model->spheres.push_back(
			{float(size) * u(random), float(size) * u(random), float(size) * u(random), float(largest) * (1 - 0.95f * share), share});
	}
	return model;
}
}  // namespace

// A sphere at a distance d fills the circle of angle asin(r / d), wherever the camera stands.
TEST(Renderer, BallsAndMeshesAppearWhereTheyAreAndAsLargeAsTheyAre)
{
	auto context = OffscreenContext::make();
	NEEDS(context);
	auto renderer = Renderer::make();
	ASSERT_TRUE(renderer) << renderer.error().message;
	PictureTarget target(kWidth, kHeight);
	auto one = std::make_shared<SpheresModel>();
	one->spheres.push_back({0.1f, 0.2f, -0.1f, 0.25f, 0});
	const auto mesh = makeSurfaceModel(ist::makeSphereMesh(0.25, 5));
	std::mt19937_64 random(11);
	std::uniform_real_distribution<double> u(-1, 1);
	RenderQuality quality;
	quality.occlusion = false;
	for (int i = 0; i < 6; ++i)
	{
		Camera camera;
		camera.set({{0.3 * u(random), 0.3 * u(random), 0}, 3, 3 * u(random), 1.2 * u(random)});
		DrawList list;
		list.ground = false;
		renderer.value()->draw(list, camera, target.frame(), {0, kWidth, kHeight}, quality);
		const Picture empty = target.read();
		ist::Pose X;
		X.rotation = rotationMatrix(ist::quaternionFromRotationVector({u(random), u(random), u(random)}));
		X.translation = {0.2 * u(random), 0.2 * u(random), 0.2 * u(random)};
		const ist::Vec3 center = X * ist::Vec3{0.1, 0.2, -0.1};
		for (const bool asBall : {true, false})
		{
			DrawList drawn = list;
			ist::Pose X_mesh = X;
			X_mesh.translation = center;
			if (asBall) drawn.spheres.push_back({one, X, 1, 1});
			else drawn.surfaces.push_back({mesh, X_mesh, {0.9f, 0.2f, 0.1f}});
			renderer.value()->draw(drawn, camera, target.frame(), {0, kWidth, kHeight}, quality);
			const Seen seen = look(target.read(), empty);
			const auto expected = camera.project(center, double(kWidth) / kHeight);
			ASSERT_TRUE(expected);
			EXPECT_NEAR(seen.x, (*expected)[0], 0.006) << asBall;
			EXPECT_NEAR(seen.y, (*expected)[1], 0.012) << asBall;
			// Half-axes of the ellipse on the picture plane, to first order in the angle off the axis.
			const ist::Vec3 off = center - camera.eye();
			const double deep = -dot(off, camera.axes().column(2)), t = 0.25 / std::sqrt(deep * deep - 0.0625),
						 pixels = kHeight / camera.heightAt(1, double(kWidth) / kHeight);
			EXPECT_NEAR(std::sqrt(seen.share * kWidth * kHeight / 3.14159265), t * pixels, 0.05 * t * pixels) << asBall;
		}
	}
}

TEST(Renderer, LeavesOutWhatIsSmallerThanAPixelAndKeepsTheRest)
{
	auto context = OffscreenContext::make();
	NEEDS(context);
	auto renderer = Renderer::make();
	ASSERT_TRUE(renderer);
	PictureTarget target(kWidth, kHeight);
	DrawList list;
	list.spheres.push_back({cloud(100000, 1, 0.02), {}, 100000, 1});
	Camera camera;
	camera.set({{}, 4, 0.4, 0.3});
	renderer.value()->beginPicture();
	renderer.value()->draw(list, camera, target.frame(), {0, kWidth, kHeight}, {});
	const RenderCost near = renderer.value()->cost();
	EXPECT_EQ(near.ballsDrawn + near.ballsLeftOut, 100000u);
	EXPECT_GT(near.ballsDrawn, 50000u);
	// Once for the picture, once for the shadow, whatever the number.
	EXPECT_LT(near.drawCalls, 12u);
	std::printf("  100,000 balls: %.1f ms of the thread that draws\n", near.microseconds / 1e3);
	camera.set({{}, 80, 0.4, 0.3});
	renderer.value()->beginPicture();
	renderer.value()->draw(list, camera, target.frame(), {0, kWidth, kHeight}, {});
	EXPECT_LT(renderer.value()->cost().ballsDrawn, near.ballsDrawn / 2);
}

TEST(Renderer, ShadowFallsUnderTheBody)
{
	auto context = OffscreenContext::make();
	NEEDS(context);
	auto renderer = Renderer::make();
	ASSERT_TRUE(renderer);
	PictureTarget target(kWidth, kHeight);
	DrawList list;
	ist::Pose X;
	X.translation.y = 1;
	list.surfaces.push_back({makeSurfaceModel(ist::makeBoxMesh({0.5, 0.05, 0.5})), X, {0.9f, 0.2f, 0.1f}});
	list.gridCell = 1000;
	Camera camera;
	camera.set({{0, 0.3, 0}, 7, 0.5, 0.5});
	RenderQuality quality;
	quality.occlusion = false;
	renderer.value()->draw(list, camera, target.frame(), {0, kWidth, kHeight}, quality);
	const Picture with = target.read();
	list.shadows = false;
	renderer.value()->draw(list, camera, target.frame(), {0, kWidth, kHeight}, quality);
	const Picture without = target.read();
	const Seen shadow = look(with, without);
	// The light comes from (0.45, 0.85, 0.30): the plate's middle is seen on the ground at -(0.45, 0.30) / 0.85.
	const auto expected = camera.project({-0.45 / 0.85, 0, -0.30 / 0.85}, double(kWidth) / kHeight);
	ASSERT_TRUE(expected);
	EXPECT_NEAR(shadow.x, (*expected)[0], 0.03);
	EXPECT_NEAR(shadow.y, (*expected)[1], 0.04);
	EXPECT_GT(shadow.share, 0.01);
}

/// Every demo as it begins, without words, whose font may differ.
class Golden : public testing::TestWithParam<DemoEntry>
{};
TEST_P(Golden, PictureLooksAsItDid)
{
	auto photographer = Photographer::make(kWidth, kHeight);
	NEEDS(photographer);
	const auto demo = GetParam().make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	const auto failed = demo->prepare(options);
	ASSERT_FALSE(failed) << failed->message;
	ASSERT_FALSE(demo->restart());
	// A pile that falls is chaotic. What a rounding does to its first impacts is seen after 0.15 s; until 0.06 s it is not.
	const double until = std::string(GetParam().name) == "pile" ? 0.06 : 0.5;
	while (demo->time() < until) demo->step(demo->stepSize());
	const Picture now = withFewerColours(photographer.value()->take(*demo, false));
	const std::string path = std::string(GOLDEN_PICTURES) + "/" + GetParam().name + ".png";
	if (std::getenv("BULLETHAPTICS_RENEW_PICTURES"))
	{
		ASSERT_FALSE(savePicture(now, path));
		return;
	}
	const auto golden = loadPicture(path);
	ASSERT_TRUE(golden) << golden.error().message;
	const double alike = similarity(now, golden.value()), worst = worstSimilarity(now, golden.value());
	std::printf("  similarity %.4f, in the worst window %.3f\n", alike, worst);
	EXPECT_GT(alike, 0.97);
	EXPECT_GT(worst, 0.3);
	if (HasFailure()) savePicture(now, std::string(TREE_FOLDER) + "/" + GetParam().name + "-now.png");
}
INSTANTIATE_TEST_SUITE_P(Demos, Golden, testing::ValuesIn(demoCatalog()), testNameOf);
