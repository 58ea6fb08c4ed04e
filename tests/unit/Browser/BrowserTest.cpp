// SPDX-License-Identifier: Zlib
#include "demos/browser/WorldDemo.h"
#include "demos/browser/view/Browser.h"
#include "demos/browser/view/OffscreenContext.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace browser;

namespace
{
/// The browser without a window, 640 by 360.
struct Rig
{
	static constexpr int kWidth = 640, kHeight = 360;
	std::unique_ptr<OffscreenContext> context;
	std::unique_ptr<Renderer> renderer;
	std::unique_ptr<PictureTarget> target;
	std::unique_ptr<Gui> gui;
	std::unique_ptr<Browser> browser;

	bool start()
	{
		auto made = OffscreenContext::make();
		if (!made) return false;
		context = std::move(made).value();
		auto drawn = Renderer::make();
		EXPECT_TRUE(drawn) << drawn.error().message;
		if (!drawn) return false;
		renderer = std::move(drawn).value();
		target = std::make_unique<PictureTarget>(kWidth, kHeight);
		gui = std::make_unique<Gui>(1);
		DemoOptions options;
		options.cache = TREE_FOLDER;
		options.spheres = 300;
		browser = std::make_unique<Browser>(*renderer, *gui, options);
		return true;
	}
	Picture draw(int width = kWidth, int height = kHeight)
	{
		gui->beginOffscreen(width, height);
		browser->draw(target->frame(), width, height);
		gui->end(target->frame(), width, height);
		return target->read();
	}
};

#define START_OR_SKIP(rig) \
	if (!rig.start()) GTEST_SKIP() << "no OpenGL without a window: apt-get install libegl1 libgl1-mesa-dri"
}  // namespace

TEST(Browser, OpensDemosAndSaysWhatItCannotOpen)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("hello");
	ASSERT_NE(rig.browser->demo(), nullptr);
	const BrowsableDemo* hello = rig.browser->demo();
	rig.browser->open("nothing");
	EXPECT_EQ(rig.browser->demo(), hello);
	EXPECT_NE(rig.browser->message().find("nothing"), std::string::npos);
	rig.browser->openMesh("/no/such/mesh.obj");
	EXPECT_EQ(rig.browser->demo(), hello);
	EXPECT_NE(rig.browser->message().find("/no/such/mesh.obj"), std::string::npos);
	rig.draw();
	rig.browser->open("packing");
	EXPECT_NE(rig.browser->demo(), hello);
	EXPECT_TRUE(rig.browser->message().empty());
}

TEST(Browser, KeysPauseStepAndRestart)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("hello");
	const BrowsableDemo& demo = *rig.browser->demo();
	rig.browser->advance(0.05);
	EXPECT_GT(demo.time(), 0);
	rig.browser->key(Key::Pause);
	const double stopped = demo.time();
	rig.browser->advance(0.05);
	EXPECT_EQ(demo.time(), stopped);
	rig.browser->key(Key::Step);
	EXPECT_NEAR(demo.time(), stopped + demo.stepSize(), 1e-12);
	rig.browser->key(Key::Restart);
	EXPECT_EQ(demo.time(), 0);
}

TEST(Browser, MouseTakesABodyAndDragsIt)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("hello");
	rig.draw();
	for (int i = 0; i < 6; ++i) rig.browser->advance(0.1);
	// The ball of the upper ring nearest to the eye is found by looking for it.
	const auto& world = static_cast<const WorldDemo&>(*rig.browser->demo());
	DrawList before;
	const_cast<WorldDemo&>(world).draw({}, before);
	const Camera& camera = rig.browser->camera();
	const double aspect = rig.browser->sceneWidth() / Rig::kHeight;
	const ist::Vec3 tube = before.surfaces[1].X_WM * ist::Vec3{0.35 * std::sin(0.6), 0, 0.35 * std::cos(0.6)};
	const auto seen = camera.project(tube, aspect);
	ASSERT_TRUE(seen);
	rig.browser->press((*seen)[0], (*seen)[1], false);
	for (int i = 1; i <= 20; ++i)
	{
		rig.browser->drag((*seen)[0], (*seen)[1] - 0.01 * i, false, false, false);
		rig.browser->advance(0.05);
	}
	DrawList after;
	const_cast<WorldDemo&>(world).draw({}, after);
	const double lifted = after.surfaces[1].X_WM.translation.y - before.surfaces[1].X_WM.translation.y;
	EXPECT_GT(lifted, 0.1);
	rig.browser->releaseMouse();
	for (int i = 0; i < 20; ++i) rig.browser->advance(0.05);
	DrawList fallen;
	const_cast<WorldDemo&>(world).draw({}, fallen);
	EXPECT_LT(fallen.surfaces[1].X_WM.translation.y, after.surfaces[1].X_WM.translation.y - 0.05);
	// On nothing the mouse turns the camera.
	const double yaw = camera.viewpoint().yaw;
	rig.browser->press(0.02, 0.02, false);
	rig.browser->drag(0.12, 0.02, false, false, false);
	EXPECT_NE(camera.viewpoint().yaw, yaw);
}

TEST(Browser, DrawsInEverySize)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("hello");
	for (const auto& [width, height] : {std::pair{640, 360}, {640, 0}, {0, 0}, {17, 300}, {1, 1}, {639, 359}}) rig.draw(width, height);
	rig.browser->key(Key::Panels);
	rig.draw(1, 1);
}

// What a key shows can be seen.
TEST(Browser, EveryKeyChangesThePicture)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("hello");
	rig.browser->key(Key::Pause);
	for (int i = 0; i < 240; ++i) rig.browser->key(Key::Step);
	const Picture panels = rig.draw();
	rig.browser->key(Key::Panels);
	EXPECT_LT(worstSimilarity(panels, rig.draw()), 0.5);
	// Without panels, whose numbers change by themselves.
	for (const Key key : {Key::Boxes, Key::Contacts, Key::Frames, Key::Wireframe, Key::Surfaces, Key::Shadows, Key::Spheres, Key::Leaves, Key::Lenses})
	{
		const Picture before = rig.draw();
		rig.browser->key(key);
		EXPECT_LT(worstSimilarity(before, rig.draw()), 0.9) << int(key);
		rig.browser->key(key);
		EXPECT_GT(worstSimilarity(before, rig.draw()), 0.99) << int(key);
	}
}
