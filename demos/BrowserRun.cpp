// SPDX-License-Identifier: Zlib
#include "demos/BrowserRun.h"

#include "demos/Present.h"
#include "demos/browser/catalog/BesideStock.h"
#include "demos/browser/catalog/DemoRun.h"
#ifdef BULLETHAPTICS_BROWSER
#include "demos/browser/view/Browser.h"
#include "demos/browser/view/Photographer.h"
#include "demos/browser/view/Window.h"
#endif
#include "demos/scenes/Pages/TextFile.h"

#include <filesystem>

namespace scenes
{
namespace
{
browser::DemoOptions demoOptions(const DemoArguments& a)
{
	browser::DemoOptions options;
	options.mesh = a.meshGiven ? a.mesh : "";
	options.up = a.up;
	options.cache = a.cache;
	options.spheres = a.spheresGiven ? a.spheres : 0;
	options.contactCache = {a.contactCache, a.maxError, a.forceError};
	options.progress = showProgress;
	options.say = say;
	return options;
}

int refuse(const ist::Error& error)
{
	say(error.message);
	return error.cancelled ? 130 : 1;
}

std::optional<ist::Error> checkShow(const DemoArguments& a)
{
	browser::DrawChoice choice;
	const std::string unknown = browser::applyChoices(a.show, choice);
	if (unknown.empty()) return std::nullopt;
	std::string known;
	for (const browser::DrawChoiceRow& row : browser::drawChoiceRows()) known += std::string(known.empty() ? "" : ", ") + row.name;
	return ist::Error{"--show knows no \"" + unknown + "\", but " + known};
}

constexpr double kFramesPerSecond = 30;

#ifdef BULLETHAPTICS_BROWSER
using browser::Photographer;

/// Unknown names were refused before.
browser::DrawChoice shown(const DemoArguments& a, const browser::BrowsableDemo& demo)
{
	browser::DrawChoice choice = demo.firstChoice();
	browser::applyChoices(a.show, choice);
	return choice;
}

/// Takes the pictures of a run: a recording, and one at the end.
struct Pictures
{
	std::unique_ptr<Photographer> photographer;
	std::optional<ist::Error> error;
	long long taken = 0;

	explicit Pictures(const DemoArguments& a)
	{
		if (a.screenshot.empty() && a.record.empty()) return;
		auto made = Photographer::make(a.width, a.height);
		if (!made) error = made.error();
		else photographer = std::move(made).value();
		std::error_code failed;
		if (a.record.empty()) return;
		if (!std::filesystem::is_directory(a.record, failed) && !std::filesystem::create_directories(a.record, failed))
			error = ist::Error{a.record + ": the folder cannot be made"};
		else if (std::filesystem::exists(pathOf(a, 0)))
			// The end of a longer recording would become the end of this one.
			error = ist::Error{a.record + ": holds a recording already; give another folder, or empty this one"};
	}
	static std::string pathOf(const DemoArguments& a, long long picture)
	{
		char name[32];
		std::snprintf(name, sizeof name, "%05lld.png", picture);
		return (std::filesystem::path(a.record) / name).string();
	}
	/// Every 1/30 s of the demo's time, from its beginning; a step that is longer leaves several alike.
	bool record(const DemoArguments& a, browser::BrowsableDemo& demo)
	{
		if (a.record.empty() || demo.time() < double(taken) / kFramesPerSecond - 1e-9) return true;
		const browser::Picture picture = photographer->take(demo, shown(a, demo), demo.viewpoint(), true);
		while (!error && demo.time() >= double(taken) / kFramesPerSecond - 1e-9) error = browser::savePicture(picture, pathOf(a, taken++));
		return !error;
	}
	void sayWhatWasRecorded(const DemoArguments& a) const
	{
		if (taken > 0)
			say(std::to_string(taken) + " pictures in " + a.record + "; a film: ffmpeg -framerate 30 -i " +
				(std::filesystem::path(a.record) / "%05d.png").string() + " -pix_fmt yuv420p film.mp4");
	}
};
#else
const char* const kWithout =
	"this build has no pictures and no window; apt-get install libglfw3-dev libimgui-dev libstb-dev libopengl-dev libegl-dev libpng-dev, "
	"then build again (--headless needs none of it)";
#endif
}  // namespace

bool isBrowserDemo(const std::string& name) { return browser::findDemo(name) != nullptr; }

void listBrowserDemos()
{
	for (const browser::DemoEntry& entry : browser::demoCatalog()) std::printf("%-13s %s\n", entry.name, entry.about);
}

int runBrowserDemo(const DemoArguments& a)
{
	const browser::DemoEntry* entry = browser::findDemo(a.demo);
	if (const auto error = checkShow(a)) return refuse(*error);
	if (a.besideStock && !entry->make()->hasStockSide())
		return refuse({a.demo + " has no side of stock Bullet: its own contact has no answer to this scene"});
	std::unique_ptr<browser::BrowsableDemo> demo = browser::makeDemo(*entry, a.besideStock);
	browser::DemoRunOptions options;
	options.frames = a.frames;
	options.dt = a.dt;
#ifdef BULLETHAPTICS_BROWSER
	Pictures pictures(a);
	if (pictures.error) return refuse(*pictures.error);
	options.afterStep = [&](long long) { return pictures.record(a, *demo); };
#else
	if (!a.screenshot.empty() || !a.record.empty()) return refuse({kWithout});
#endif
	const browser::DemoOptions demoChoice = demoOptions(a);
	demo->setContactCache(demoChoice.contactCache);
	if (const auto error = demo->prepare(demoChoice)) return refuse(*error);
	const auto outcome = browser::runDemo(*demo, entry->name, entry->about, options);
	if (!outcome) return refuse(outcome.error());
#ifdef BULLETHAPTICS_BROWSER
	if (!pictures.error && !a.screenshot.empty())
		pictures.error = browser::savePicture(pictures.photographer->take(*demo, shown(a, *demo), demo->viewpoint(), true), a.screenshot);
	if (pictures.error) return refuse(*pictures.error);
	pictures.sayWhatWasRecorded(a);
#endif
	if (!a.saveScene.empty())
	{
		const auto leftOut = demo->saveScene(a.saveScene);
		if (!leftOut) return refuse(leftOut.error());
		say("scene: " + a.saveScene);
		for (const std::string& what : leftOut.value()) say("the scene file does not hold " + what);
	}
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

#ifdef BULLETHAPTICS_BROWSER
int openBrowser(const DemoArguments& a)
{
	if (const auto error = checkShow(a)) return refuse(*error);
	browser::WindowOptions options;
	options.demo = demoOptions(a);
	if (!a.demo.empty()) options.first = a.demo;
	options.besideStock = a.besideStock;
	options.show = a.show;
	options.pictures = a.frames;
	options.width = a.sizeGiven ? a.width : 1280;
	options.height = a.sizeGiven ? a.height : 800;
	options.screenshot = a.windowScreenshot;
	options.device = a.device;
	options.forces = a.forces;
	const auto error = browser::openWindow(options);
	return error ? refuse(*error) : 0;
}

namespace
{
/// A picture of the end of a demo's run, and what it found, to the page.
std::optional<ist::Error> addToGallery(
	const DemoArguments& a, const browser::DemoEntry& entry, bool besideStock, Photographer& photographer, std::string& page, bool& good)
{
	const std::unique_ptr<browser::BrowsableDemo> demo = browser::makeDemo(entry, besideStock);
	if (auto error = demo->prepare(demoOptions(a))) return error;
	const auto outcome = browser::runDemo(*demo, entry.name, entry.about, {});
	if (!outcome) return outcome.error();
	const std::string name = std::string(entry.name) + (besideStock ? "-beside-stock" : ""), file = name + ".png";
	if (auto error = browser::savePicture(
			browser::withFewerColours(photographer.take(*demo)), (std::filesystem::path(a.gallery) / file).string()))
		return error;
	page += "\n**" + std::string(entry.name) + ".** " + entry.about + ".\n\n![" + name + "](" + file +
		")\n\n| number | found | unit |\n|---|---|---|\n";
	for (const auto& row : browser::summaryRows(outcome.value()))
		if (row[2] != "us") page += "| " + row[0] + " | " + row[1] + " | " + row[2] + " |\n";
	good = good && outcome.value().ok();
	say(name + (outcome.value().ok() ? ": good" : ": NOT as expected"));
	return std::nullopt;
}
}  // namespace

int makeGallery(const DemoArguments& a)
{
	const std::filesystem::path folder = a.gallery;
	std::error_code failed;
	if (!std::filesystem::is_directory(folder, failed) && !std::filesystem::create_directories(folder, failed))
		return refuse({a.gallery + ": the folder cannot be made"});
	auto photographer = Photographer::make(640, 360);
	if (!photographer) return refuse(photographer.error());
	photographer.value().reset();  // one context at a time
	const auto window = browser::takeBrowserPicture("bunny", 2.5, demoOptions(a), 880, 500);
	if (!window) return refuse(window.error());
	if (const auto error = browser::savePicture(browser::withFewerColours(window.value()), (folder / "window.png").string()))
		return refuse(*error);
	photographer = Photographer::make(640, 360);
	if (!photographer) return refuse(photographer.error());
	std::string page = "# Gallery\nMade by `haptic_demos --gallery FOLDER`: every demo of the browser at the end of its run, with what it "
					   "found. A mesh of your own: `--mesh FILE`, or drop it on the window.\n\n![the window](window.png)\n",
				group;
	bool good = true;
	for (const browser::DemoEntry& entry : browser::demoCatalog())
	{
		if (group != entry.group) page += "\n## " + (group = entry.group) + "\n";
		if (const auto error = addToGallery(a, entry, false, *photographer.value(), page, good)) return refuse(*error);
	}
	page += "\n## Beside stock Bullet\nThe same scenes with Bullet's own contact on the left: `haptic_demos --demo NAME --beside-stock`, "
			"or key h.\n";
	for (const char* name : {"stack", "peg", "gears"})
		if (const auto error = addToGallery(a, *browser::findDemo(name), true, *photographer.value(), page, good)) return refuse(*error);
	if (!writeTextFile((folder / "README.md").string(), page)) return refuse({a.gallery + ": the page cannot be written"});
	return good ? 0 : 1;
}
#else
int openBrowser(const DemoArguments&) { return refuse({kWithout}); }
int makeGallery(const DemoArguments&) { return refuse({kWithout}); }
#endif
}  // namespace scenes
