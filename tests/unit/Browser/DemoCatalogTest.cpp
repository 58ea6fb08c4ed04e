// SPDX-License-Identifier: Zlib
#include "demos/browser/catalog/DemoCatalog.h"
#include "demos/browser/catalog/DemoRun.h"

#include "BulletISTCollision/Json/JsonValue.h"
#include "tests/unit/Browser/StillDemo.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

using namespace browser;

namespace
{
/// A demo that counts its steps.
class Counting : public StillDemo
{
public:
	std::optional<ist::Error> restart() override { return m_time = 0, std::nullopt; }
	void step(double seconds) override { m_time += seconds; }
	double stepSize() const override { return 0.1; }
	double time() const override { return m_time; }
	std::vector<Figure> figures() const override { return {{"time", "s", m_time, expected, 1e-9}}; }

	double expected = 1;

private:
	double m_time = 0;
};
}  // namespace

TEST(DemoCatalog, HasEachNameOnceAndGroupsTogether)
{
	std::set<std::string> names, groups;
	std::string group;
	for (const DemoEntry& entry : demoCatalog())
	{
		EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
		EXPECT_EQ(findDemo(entry.name), &entry);
		EXPECT_NE(entry.make(), nullptr);
		if (group == entry.group) continue;
		group = entry.group;
		EXPECT_TRUE(groups.insert(group).second) << group;
	}
	EXPECT_EQ(findDemo("no such demo"), nullptr);
}

TEST(DemoCatalog, SearchWantsEveryWordInAnyCase)
{
	EXPECT_EQ(searchDemos("").size(), demoCatalog().size());
	ASSERT_EQ(searchDemos("SWORD ring").size(), 1u);
	EXPECT_STREQ(searchDemos("SWORD ring")[0]->name, "sword");
	EXPECT_TRUE(searchDemos("sword archimedes").empty());
	EXPECT_GE(searchDemos("physics").size(), 3u);
}

// As many pictures as demos, each shown with the words of today.
TEST(DemoCatalog, TheGalleryShowsEveryDemoAndNothingElse)
{
	const std::filesystem::path folder = GALLERY;
	std::ifstream file(folder / "README.md");
	const std::string page{std::istreambuf_iterator<char>(file), {}};
	for (const DemoEntry& entry : demoCatalog())
	{
		const std::string name = entry.name;
		EXPECT_NE(page.find("**" + name + ".** " + entry.about + ".\n\n![" + name + "](" + name + ".png)"), std::string::npos) << name;
		EXPECT_TRUE(std::filesystem::exists(folder / (name + ".png"))) << name;
	}
	for (const auto& entry : std::filesystem::directory_iterator(folder))
		if (entry.path().extension() == ".png")
		{
			EXPECT_NE(page.find("(" + entry.path().filename().string() + ")"), std::string::npos) << entry.path() << " is shown nowhere";
		}
}

TEST(DemoRun, JudgesOnlyWhatRanToItsEnd)
{
	Counting demo;
	auto whole = runDemo(demo, "counting", "", {});
	ASSERT_TRUE(whole);
	EXPECT_EQ(whole.value().frames, 10);
	EXPECT_TRUE(whole.value().complete && whole.value().ok());
	DemoRunOptions options;
	options.frames = 3;
	auto part = runDemo(demo, "counting", "", options);
	ASSERT_TRUE(part);
	EXPECT_NEAR(part.value().seconds, 0.3, 1e-12);
	EXPECT_TRUE(!part.value().complete && part.value().ok());
	demo.expected = 2;
	EXPECT_FALSE(runDemo(demo, "counting", "", {}).value().ok());
	options.frames = -1;
	options.dt = 0.25;
	EXPECT_EQ(runDemo(demo, "counting", "", options).value().frames, 4);
}

TEST(DemoRun, PrintsWhatIsNotFiniteAsNull)
{
	DemoOutcome outcome;
	outcome.figures = {{"lost", "m", std::numeric_limits<double>::quiet_NaN()}, {"kept", "m", 1, 1, 0.5}};
	const ist::JsonValue json = ist::parseJson(makeJson(outcome)).value;
	EXPECT_EQ(json["schema"].number(), 1);
	EXPECT_TRUE(json["figures"][0]["value"].isNull() && json["figures"][0]["expected"].isNull());
	EXPECT_EQ(json["figures"][1]["tolerance"].number(), 0.5);
	EXPECT_TRUE(json["ok"].isFlag() && !json["ok"].flag());
}
