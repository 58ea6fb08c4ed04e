// SPDX-License-Identifier: Zlib
#include "demos/browser/view/Browser.h"
#include "demos/browser/base/WorldDemo.h"
#include "demos/browser/render/OffscreenContext.h"

#include "tests/unit/Browser/RecordedHand.h"
#include "tests/unit/Browser/StillDemo.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"
#include "tests/unit/DeviceBridge/Drivers/SerialGlove.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

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

	bool start(double density = 1)
	{
		auto made = OffscreenContext::make();
		if (!made) return false;
		context = std::move(made).value();
		auto drawn = Renderer::make();
		EXPECT_TRUE(drawn) << drawn.error().message;
		if (!drawn) return false;
		renderer = std::move(drawn).value();
		target = std::make_unique<PictureTarget>(int(density * kWidth), int(density * kHeight));
		gui = std::make_unique<Gui>(density);
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

/// Words alone, all in one place.
class Labels : public StillDemo
{
public:
	void draw(const DrawChoice&, DrawList& list) override
	{
		for (int i = 0; i < count; ++i) list.texts.push_back({{0, 0, 0}, "12.3 N", {0.1f, 0.1f, 0.12f}});
	}

	int count = 0;
};

TEST(ScenePainter, LabelsDoNotHideEachOther)
{
	Rig rig;
	START_OR_SKIP(rig);
	Labels labels;
	Camera camera;
	camera.set({{}, 1, 0.4, 0.3});
	ScenePainter painter;
	const auto picture = [&](int count) {
		labels.count = count;
		rig.gui->beginOffscreen(Rig::kWidth, Rig::kHeight);
		painter.paint({{&labels, "", {0, Rig::kWidth, Rig::kHeight}}}, {}, camera, *rig.renderer, rig.target->frame(), {}, true);
		rig.gui->end(rig.target->frame(), Rig::kWidth, Rig::kHeight);
		return rig.target->read();
	};
	Picture none = picture(0);
	const auto covered = [&](int count) {
		const Picture with = picture(count);
		int pixels = 0;
		for (size_t i = 0; i < with.pixels.size(); i += 3) pixels += with.pixels[i] != none.pixels[i];
		return double(pixels);
	};
	const double one = covered(1);
	ASSERT_GT(one, 100);
	EXPECT_NEAR(covered(4), 4 * one, 0.3 * one);
	// Nor do they climb without end: from near the lower edge all of these would still be in the picture.
	camera.set({{0, 0.23, 0}, 1, 0.4, 0.3});
	none = picture(0);
	EXPECT_NEAR(covered(16), covered(13), 0.1 * one);
	EXPECT_GT(covered(13), covered(12) + 0.5 * one);
}

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

TEST(Browser, PacksAMeshThatIsDropped)
{
	Rig rig;
	START_OR_SKIP(rig);
	const std::string path =
		(std::filesystem::temp_directory_path() / ("dropped" + std::to_string(std::random_device()()) + ".obj")).string();
	std::ofstream(path) << "v 0 0 0\nv 3 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
	rig.browser->open("hello");
	rig.browser->openMesh(path);
	std::filesystem::remove(path);
	EXPECT_EQ(rig.browser->message(), "");
	DrawList list;
	const_cast<BrowsableDemo*>(rig.browser->demo())->draw({.spheres = true}, list);
	ASSERT_EQ(list.spheres.size(), 1u);
	EXPECT_EQ(list.spheres[0].model->spheres.size(), 300u);
	// As long as it is drawn, three to one to one.
	const ist::Vec3 size = list.surfaces.at(0).model->box.size();
	EXPECT_NEAR(size.x / size.y, 3, 1e-6);
	EXPECT_NEAR(size.x / size.z, 3, 1e-6);
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

/// The columns of a picture from one share of its width to another, below the titles.
Picture columns(const Picture& p, double from, double to)
{
	const int first = int(from * p.width), last = int(to * p.width), top = p.height / 8;
	Picture part{last - first, p.height - top, {}};
	for (int y = top; y < p.height; ++y)
		part.pixels.insert(part.pixels.end(), p.pixels.begin() + 3 * (y * p.width + first), p.pixels.begin() + 3 * (y * p.width + last));
	return part;
}

// The same start looks the same in both halves; later stock Bullet has dropped what ours carries.
TEST(Browser, HalvesShowTwoScenesUnderOneCamera)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("heavy-on-light");
	rig.browser->key(Key::Panels);
	const Picture whole = rig.draw();
	const double distance = rig.browser->camera().viewpoint().distance;
	rig.browser->camera().zoom(2);
	rig.browser->key(Key::Halves);
	EXPECT_LT(rig.browser->camera().viewpoint().distance, distance) << "the camera stays";
	EXPECT_EQ(rig.browser->demo()->time(), 0);
	rig.browser->key(Key::Pause);
	const auto alike = [&] {
		const Picture p = rig.draw();
		return worstSimilarity(columns(p, 0.02, 0.48), columns(p, 0.52, 0.98));
	};
	const double start = alike();
	for (int i = 0; i < 180; ++i) rig.browser->key(Key::Step);
	const double end = alike();
	rig.browser->camera().turn(0.3, 0.1);
	const double turned = alike();
	std::printf("  halves alike: %.2f at first, %.2f after 3 s, %.2f turned\n", start, end, turned);
	EXPECT_GT(start, 0.9);
	EXPECT_LT(end, 0.3);
	rig.browser->key(Key::Halves);
	rig.browser->camera().set(rig.browser->demo()->viewpoint());
	EXPECT_GT(worstSimilarity(whole, rig.draw()), 0.9);
}

TEST(Browser, HalvesKeepTheParametersAndSayWhereThereAreNone)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("heavy-on-light");
	*const_cast<BrowsableDemo*>(rig.browser->demo())->parameters()[0].value = 77;
	rig.browser->key(Key::Halves);
	EXPECT_EQ(*const_cast<BrowsableDemo*>(rig.browser->demo())->parameters()[0].value, 77);
	EXPECT_FALSE(const_cast<BrowsableDemo*>(rig.browser->demo())->halves().empty());
	rig.browser->open("floating");
	EXPECT_TRUE(const_cast<BrowsableDemo*>(rig.browser->demo())->halves().empty());
	rig.browser->key(Key::Halves);
	EXPECT_NE(rig.browser->message().find("floating"), std::string::npos);
	rig.browser->open("stack");
	EXPECT_FALSE(const_cast<BrowsableDemo*>(rig.browser->demo())->halves().empty()) << "the choice stays";
}

TEST(Browser, MouseTakesWhatIsInTheHalfUnderIt)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->key(Key::Halves);
	rig.browser->open("heavy-on-light");
	auto halves = const_cast<BrowsableDemo*>(rig.browser->demo())->halves();
	ASSERT_EQ(halves.size(), 2u);
	rig.draw();
	const auto heightIn = [&](size_t i) {
		DrawList list;
		halves[i].demo->draw({}, list);
		return list.surfaces[1].X_WM.translation.y;
	};
	const double aspect = 0.5 * rig.browser->sceneWidth() / Rig::kHeight;
	for (const int i : {0, 1})
	{
		rig.browser->key(Key::Restart);
		const auto seen = rig.browser->camera().project({0, 1.5, 0}, aspect);
		ASSERT_TRUE(seen);
		const double x = 0.5 * (i + (*seen)[0]);
		rig.browser->press(x, (*seen)[1], false);
		for (int k = 1; k <= 20; ++k)
		{
			rig.browser->drag(x, (*seen)[1] - 0.01 * k, false, false, false);
			rig.browser->advance(0.05);
		}
		EXPECT_GT(heightIn(size_t(i)), 1.7) << i;
		EXPECT_LT(heightIn(size_t(1 - i)), 1.51) << i;
		rig.browser->releaseMouse();
	}
}

// Twice the pixels to the inch: twice the text, and a picture that looks the same at half the size.
TEST(Browser, TextGrowsWithTheDensityOfTheScreen)
{
	Picture pictures[2];
	for (const int density : {1, 2})
	{
		Rig rig;
		if (!rig.start(density)) GTEST_SKIP() << "no OpenGL without a window";
		rig.browser->open("hello");
		rig.browser->key(Key::Pause);
		// Windows are laid out in the first pictures.
		for (int i = 0; i < 3; ++i) pictures[density - 1] = rig.draw(density * Rig::kWidth, density * Rig::kHeight);
		EXPECT_EQ(rig.browser->sceneLeft(), std::min(330.0 * density, std::round(0.45 * density * Rig::kWidth)));
	}
	Picture halved{Rig::kWidth, Rig::kHeight, std::vector<uint8_t>(3 * Rig::kWidth * Rig::kHeight)};
	for (int y = 0; y < Rig::kHeight; ++y)
		for (int x = 0; x < Rig::kWidth; ++x)
			for (int c = 0; c < 3; ++c)
			{
				const auto at = [&](int dx, int dy) {
					return int(pictures[1].pixels[size_t(3 * ((2 * y + dy) * 2 * Rig::kWidth + 2 * x + dx) + c)]);
				};
				halved.pixels[size_t(3 * (y * Rig::kWidth + x) + c)] = uint8_t((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4);
			}
	const double alike = similarity(pictures[0], halved);
	std::printf("  similarity %.3f\n", alike);
	EXPECT_GT(alike, 0.85);
}

TEST(Browser, DrawsInEverySize)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("hello");
	for (const auto& [width, height] : {std::pair{640, 360}, {640, 0}, {0, 0}, {17, 300}, {1, 1}, {639, 359}}) rig.draw(width, height);
	rig.browser->key(Key::Panels);
	rig.draw(1, 1);
	rig.browser->key(Key::Halves);
	for (const auto& [width, height] : {std::pair{640, 360}, {639, 359}, {1, 1}, {0, 0}, {2, 300}}) rig.draw(width, height);
}

// Its hand is at rest where it was; the browser goes on, and says so until the device is back.
TEST(Browser, ALostDeviceIsSaidAndTheDemoGoesOn)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("hello");
	const RecordedHand recorded({0, 0.05, 0}, 5);
	auto device = DeviceHand::open(recorded.address());
	ASSERT_TRUE(device);
	rig.browser->use(std::move(device).value());
	for (int i = 0; i < 5; ++i) rig.browser->advance(0.02);
	EXPECT_EQ(rig.browser->message(), "");
	for (int i = 0; i < 3; ++i) rig.browser->advance(0.02);
	EXPECT_EQ(rig.browser->message().rfind("the device is lost", 0), 0u) << rig.browser->message();
	const double lost = rig.browser->demo()->time();
	rig.browser->advance(0.05);
	EXPECT_GT(rig.browser->demo()->time(), lost);
	rig.browser->open("packing");
	rig.browser->advance(0.02);
	EXPECT_EQ(rig.browser->message().rfind("the device is lost", 0), 0u) << "of whatever demo";
	// Another device, and no step: the pictures differ by what is said alone.
	const auto laidOut = [&] { return rig.draw(), rig.draw(); };
	const Picture before = laidOut();
	device = DeviceHand::open(recorded.address());
	ASSERT_TRUE(device);
	rig.browser->use(std::move(device).value());
	const Picture well = laidOut();
	EXPECT_LT(worstSimilarity(before, well), 0.9) << "it can be read in the panel";
	EXPECT_GT(worstSimilarity(well, rig.draw()), 0.99);
}

// The bars of the two histograms, of the times of steps and of pictures, are the only blue that the profile adds while the demo rests.
TEST(Browser, ProfileShowsHowTimesAreSpread)
{
	Rig rig;
	START_OR_SKIP(rig);
	constexpr int kWide = 700, kTall = 1400;
	rig.target = std::make_unique<PictureTarget>(kWide, kTall);
	rig.browser->open("hello");
	for (int i = 0; i < 60; ++i) rig.browser->key(Key::Step);
	ASSERT_TRUE(rig.browser->paused());
	for (int i = 0; i < 40; ++i) rig.browser->advance(i % 4 ? 0.016 : 0.024);
	const auto blue = [&] {
		rig.draw(kWide, kTall);
		const Picture picture = rig.draw(kWide, kTall);
		int count = 0;
		for (int y = 0; y < kTall; ++y)
			for (int x = 0; x < int(rig.browser->sceneLeft()); ++x)
			{
				const uint8_t* p = &picture.pixels[size_t(3 * (y * kWide + x))];
				count += std::abs(p[0] - 0) < 8 && std::abs(p[1] - 114) < 8 && std::abs(p[2] - 178) < 8;
			}
		return count;
	};
	const int without = blue();
	rig.browser->key(Key::Profile);
	// Pictures take three times in four as long as the shortest: a bar over the whole height.
	const int bars = blue() - without;
	std::printf("  %d pixels of bars\n", bars);
	EXPECT_GT(bars, 200);
	rig.browser->key(Key::Profile);
	EXPECT_EQ(blue(), without);
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
	for (const Key key : {Key::Boxes, Key::Contacts, Key::Frames, Key::Wireframe, Key::Surfaces, Key::Shadows, Key::Spheres,
			 Key::SphereLevels, Key::Leaves, Key::Levels, Key::Lenses, Key::Pairs})
	{
		const Picture before = rig.draw();
		rig.browser->key(key);
		EXPECT_LT(worstSimilarity(before, rig.draw()), 0.9) << int(key);
		rig.browser->key(key);
		EXPECT_GT(worstSimilarity(before, rig.draw()), 0.99) << int(key);
	}
}

TEST(Browser, ADeviceIsChosenFeltAndLetGo)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("bunny");
	rig.browser->chooseDevice("sim:nothing", true);
	EXPECT_NE(rig.browser->message().find("No simulated device is called"), std::string::npos) << rig.browser->message();
	rig.browser->chooseDevice("sim:sigma7", true);
	EXPECT_NE(rig.browser->message().find("felt at 1 kHz"), std::string::npos) << rig.browser->message();
	for (int i = 0; i < 10; ++i) rig.browser->advance(1.0 / 60);
	rig.draw();
	rig.browser->key(Key::Restart);  // the hand feels the tool of the new world
	EXPECT_NE(rig.browser->message().find(" N"), std::string::npos) << rig.browser->message();
	rig.browser->open("packing");
	EXPECT_NE(rig.browser->message().find("no world of bodies that a hand could feel"), std::string::npos) << rig.browser->message();
	rig.browser->open("bunny");
	rig.browser->chooseDevice("", false);
	EXPECT_EQ(rig.browser->message(), "");
	rig.browser->advance(1.0 / 60);
}

TEST(Browser, ListsAddressesThatOpen)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("bunny");
	rig.browser->lookForDevices();
	size_t simulated = 0;
	const std::vector<devicebridge::DriverReport> all = rig.browser->foundDevices();
	EXPECT_TRUE(std::is_partitioned(all.begin(), all.end(), [](const auto& found) { return found.missing.empty(); }));
	for (const devicebridge::DriverReport& found : all)
	{
		EXPECT_EQ(std::count(found.scheme.begin(), found.scheme.end(), ':'), 1) << found.scheme;
		if (found.scheme.rfind("sim:", 0) != 0) continue;
		rig.browser->chooseDevice(found.scheme, false);
		EXPECT_EQ(rig.browser->message(), "") << found.scheme;
		++simulated;
	}
	EXPECT_GE(simulated, 5U);
}

TEST(Browser, CalibratesAGloveAndUsesItThen)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("bunny");
	const std::string file = std::filesystem::path(testing::TempDir()) / "browser-glove.json";
	rig.browser->calibrate("sim:touch", file);
	EXPECT_EQ(rig.browser->fitting(), nullptr);
	EXPECT_NE(rig.browser->message().find("needs no calibration"), std::string::npos) << rig.browser->message();

	using State = devicebridge::GloveFitting::State;
	const auto until = [&](const auto& isSo) {
		return devicebridge::within([&] {
			rig.browser->advance(1.0 / 60);
			return isSo();
		});
	};
	const auto pose = [](int value) {
		devicebridge::GloveValues values;
		values.fill(static_cast<uint8_t>(value));
		return values;
	};
	devicebridge::SerialGlove glove(22);
	glove.set(pose(60));
	rig.browser->calibrate("glove:" + glove.path(), file);
	rig.browser->chooseDevice("sim:touch", false);
	EXPECT_EQ(rig.browser->fitting(), nullptr) << "another device ends it";
	for (const int fist : {62, 160})  // a fist that is none, then one
	{
		glove.set(pose(60));
		rig.browser->calibrate("glove:" + glove.path(), file);
		ASSERT_NE(rig.browser->fitting(), nullptr) << rig.browser->message();
		rig.draw();
		rig.browser->fitting()->confirm();
		EXPECT_TRUE(until([&] { return rig.browser->fitting()->state() == State::Pose; }));
		glove.set(pose(fist));
		rig.browser->fitting()->confirm();
		rig.draw();
		if (fist == 160) break;
		EXPECT_TRUE(until([&] { return rig.browser->fitting() == nullptr; }));
		EXPECT_NE(rig.browser->message().find("moves by 2 steps"), std::string::npos) << rig.browser->message();
		EXPECT_FALSE(std::filesystem::exists(file));
	}
	EXPECT_TRUE(until([&] { return rig.browser->fitting()->state() == State::Written; }));
	EXPECT_EQ(rig.browser->message(), "");
	ASSERT_NE(rig.browser->device(), nullptr);
	EXPECT_TRUE(until([&] { return rig.browser->device()->state().find("moves no tool") != std::string::npos; }))
		<< rig.browser->device()->state();
	rig.draw();
	std::filesystem::remove(file);
}

TEST(Browser, SavesWhatItShowsAsASceneFile)
{
	Rig rig;
	START_OR_SKIP(rig);
	rig.browser->open("stack");
	const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "browser-scene";
	std::filesystem::create_directories(folder);
	rig.browser->saveScene((folder / "stack.json").string());
	EXPECT_EQ(rig.browser->message().find("scene file: "), 0u) << rig.browser->message();
	EXPECT_TRUE(std::filesystem::exists(folder / "stack.json"));
	std::filesystem::remove_all(folder);
	rig.browser->saveScene("no/such/folder/stack.json");
	EXPECT_EQ(rig.browser->message().find("scene file: "), std::string::npos) << rig.browser->message();
}
