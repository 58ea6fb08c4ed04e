// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "demos/browser/catalog/DemoRun.h"
#include "tests/EachDemo.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

using namespace browser;

namespace
{
bool isFinite(const ist::Pose& X) { return ist::isRigid(X, 1e-3); }

void expectDrawable(const DrawList& list)
{
	for (const DrawnSurface& s : list.surfaces) EXPECT_TRUE(s.model && isFinite(s.X_WM));
	for (const DrawnSpheres& s : list.spheres) EXPECT_TRUE(s.model && isFinite(s.X_WM) && s.count <= s.model->spheres.size());
	for (const DrawnDisc& d : list.discs)
		EXPECT_TRUE(ist::isFinite(d.center) && ist::isFinite(d.normal) && std::isfinite(d.radius) && std::isfinite(d.thickness));
	for (const DrawnArrow& a : list.arrows) EXPECT_TRUE(ist::isFinite(a.from) && ist::isFinite(a.to));
	for (const DrawnLine& l : list.lines) EXPECT_TRUE(ist::isFinite(l.from) && ist::isFinite(l.to));
}

/// With a tool of its own, without one, with bodies that fall, and without a world. A hand takes real time.
std::vector<DemoEntry> demosOfEachKind()
{
	std::vector<DemoEntry> chosen;
	for (const DemoEntry& entry : demoCatalog())
		for (const char* name : {"bunny", "hello", "shapes", "dial"})
			if (entry.name == std::string(name)) chosen.push_back(entry);
	return chosen;
}
}  // namespace

/// The figures of each demo must agree with the closed form or the law that they carry.
class DemoFigures : public testing::TestWithParam<DemoEntry>
{};
TEST_P(DemoFigures, AreAsPhysicsSays)
{
	const auto demo = GetParam().make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	const auto failed = demo->prepare(options);
	ASSERT_FALSE(failed) << failed->message;
	const auto outcome = runDemo(*demo, GetParam().name, GetParam().about, {});
	ASSERT_TRUE(outcome) << outcome.error().message;
	EXPECT_TRUE(outcome.value().complete);
	int judged = 0;
	for (const Figure& f : outcome.value().figures)
	{
		judged += f.judged();
		std::printf("  %-46s %12.6g %-8s %s%.6g +- %.2g\n", f.name.c_str(), f.value, f.unit.c_str(), f.judged() ? "of " : "unjudged ",
			f.expected, f.tolerance);
		EXPECT_TRUE(f.ok()) << f.name;
	}
	EXPECT_GT(judged, 0);
	DrawChoice everything;
	everything.spheres = everything.leaves = everything.lenses = everything.boxes = everything.frames = everything.constraints = true;
	DrawList list;
	demo->draw(everything, list);
	expectDrawable(list);
}
INSTANTIATE_TEST_SUITE_P(Demos, DemoFigures, testing::ValuesIn(demoCatalog()), testNameOf);

/// A hand feels each demo of bodies: a simulated one presses its tool, or a ball above the highest point, by as much as the ball is wide.
class DemoHand : public testing::TestWithParam<DemoEntry>
{};
TEST_P(DemoHand, TouchesABodyOrSaysWhyItCannot)
{
	const auto demo = GetParam().make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	ASSERT_FALSE(demo->prepare(options));
	ASSERT_FALSE(demo->restart());
	while (demo->time() < std::min(3.0, demo->duration())) demo->step(demo->stepSize());  // until what falls has come down
	auto device = devicebridge::DeviceRegistry().open("sim:sigma7?press=0.02");
	ASSERT_TRUE(device) << device.error().message;
	const auto refused = demo->feelWith(*device.value(), 3 * demo->viewpoint().distance);
	if (!dynamic_cast<WorldDemo*>(demo.get()))
	{
		ASSERT_TRUE(refused);
		EXPECT_EQ(refused->message, "this demo has no world of bodies that a hand could feel");
		return;
	}
	ASSERT_FALSE(refused) << refused->message;
	const auto touches = [&] {
		return demo->felt().find("felt at 1 kHz, touches ") == 0 && demo->felt().find("touches 0") == std::string::npos;
	};
	for (int picture = 0; picture < 1800 && !touches(); ++picture)
	{
		demo->step(1.0 / 60);
		std::this_thread::sleep_for(std::chrono::microseconds(16667));
	}
	EXPECT_TRUE(touches()) << demo->felt();
	demo->stopFeeling();
	EXPECT_TRUE(demo->felt().empty());
	demo->step(demo->stepSize());
}
INSTANTIATE_TEST_SUITE_P(Demos, DemoHand, testing::ValuesIn(demosOfEachKind()), testNameOf);

/// Each demo is run with its parameters at both ends, and with a hand that grabs what it meets.
class DemoUse : public testing::TestWithParam<DemoEntry>
{};
TEST_P(DemoUse, BearsEveryParameterAndEveryPull)
{
	const auto demo = GetParam().make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	ASSERT_FALSE(demo->prepare(options));
	for (const double end : {0.0, 1.0})
	{
		for (Parameter& p : demo->parameters()) *p.value = p.least + end * (p.most - p.least);
		ASSERT_FALSE(demo->restart());
		EXPECT_EQ(demo->time(), 0);
		const Viewpoint view = demo->viewpoint();
		for (int i = 0; i < 12; ++i)
		{
			demo->step(demo->stepSize());
			const ist::Vec3 from = view.target + view.distance * ist::Vec3{std::sin(i), 0.7, std::cos(i)};
			if (demo->grab(from, normalized(view.target - from))) demo->drag(0.1 * view.distance * ist::Vec3{1, 1, 0}, {0.5, 0, 0.2});
			if (i % 4 == 3) demo->release();
			demo->keepAwake(i % 2);
			DrawList list;
			demo->draw({}, list);
			expectDrawable(list);
			demo->report();
		}
		for (const Figure& f : demo->figures()) EXPECT_TRUE(std::isfinite(f.value)) << f.name;
	}
}
TEST_P(DemoUse, RepeatsItselfAfterARestart)
{
	const auto demo = GetParam().make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	ASSERT_FALSE(demo->prepare(options));
	DemoRunOptions few;
	few.frames = 20;
	const auto first = runDemo(*demo, "", "", few), second = runDemo(*demo, "", "", few);
	ASSERT_TRUE(first && second);
	for (size_t i = 0; i < first.value().figures.size(); ++i) EXPECT_EQ(first.value().figures[i].value, second.value().figures[i].value);
}
INSTANTIATE_TEST_SUITE_P(Demos, DemoUse, testing::ValuesIn(demoCatalog()), testNameOf);

TEST(DemoMesh, ThatIsMissingIsNamed)
{
	for (const char* name : {"packing", "bunny", "shapes", "floating"})
	{
		DemoOptions options;
		options.mesh = "/no/such/mesh.obj";
		const auto demo = findDemo(name)->make();
		const auto failed = demo->prepare(options);
		ASSERT_TRUE(failed) << name;
		EXPECT_NE(failed->message.find("/no/such/mesh.obj"), std::string::npos) << failed->message;
	}
}

TEST(StockBullet, DropsTheHeavyCubeThatOursCarries)
{
	const auto demo = findDemo("stock-against-ours")->make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	ASSERT_FALSE(demo->prepare(options));
	const auto outcome = runDemo(*demo, "", "", {});
	ASSERT_TRUE(outcome);
	EXPECT_LT(outcome.value().figures.back().value, 1);
}
