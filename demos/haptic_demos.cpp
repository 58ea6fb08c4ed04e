// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Tools/ProgressBar.h"
#include "demos/BrowserRun.h"
#include "demos/DemoArguments.h"
#include "demos/Present.h"
#include "demos/scenes/Assembly/AssemblyReport.h"
#include "demos/scenes/Carry/CarryReport.h"
#include "demos/scenes/Extremes/Continuity.h"
#include "demos/scenes/Grasp/GraspLoad.h"
#include "demos/scenes/Grasp/GraspReport.h"
#include "demos/scenes/HapticBunny/HapticBunnyReport.h"
#include "demos/scenes/Pages/SafetyPage.h"
#include "demos/scenes/Pages/TextFile.h"
#include "demos/scenes/Pages/ZWidthPage.h"
#include "demos/scenes/Scene/PaperFigures.h"
#include "demos/scenes/Scene/SceneReport.h"
#include "demos/scenes/Study/StudyRun.h"
#include "demos/scenes/Truth/MeshToQuery.h"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

namespace scenes
{
namespace
{
ist::tools::ProgressBar& progressBar()
{
	static ist::tools::ProgressBar bar;
	return bar;
}
}  // namespace

bool showProgress(const char* stage, double fraction)
{
	progressBar().show(stage, fraction);
	return true;
}

void endProgress() { progressBar().finish(); }

void say(const std::string& text)
{
	endProgress();
	std::fprintf(stderr, "haptic_demos: %s\n", text.c_str());
}
}  // namespace scenes

namespace
{
using scenes::DemoArguments;
using scenes::present;
using scenes::say;
using scenes::showProgress;

int refuse(const DemoArguments& a, const ist::Error& error)
{
	say(error.message);
	if (a.mesh == DemoArguments::kDefaultMesh) std::fprintf(stderr, "The default mesh comes with: apt-get install glmark2-data\n");
	return 1;
}

int runBunnyQuery(const DemoArguments& a)
{
	scenes::MeshToQueryOptions options;
	options.mesh = a.mesh;
	options.unit = a.unit;
	options.up = a.up;
	options.spheres = a.spheres;
	options.progress = showProgress;
	const ist::Result<scenes::MeshToQueryOutcome> outcome = scenes::runMeshToQuery(options);
	if (!outcome) return refuse(a, outcome.error());
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

int runContinuity(const DemoArguments& a)
{
	scenes::ContinuityOptions options;
	options.mesh = a.mesh;
	options.up = a.up;
	options.spheres = a.spheres;
	options.cache = a.cache;
	options.progress = showProgress;
	options.say = say;
	const auto outcome = scenes::runContinuity(options);
	if (!outcome) return refuse(a, outcome.error());
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

int runZWidth(const DemoArguments& a)
{
	const auto outcome = scenes::runZWidth({"sigma7", "touchx", "falcon", "virtuose6d"}, {0, 1, 3, 10});
	if (!outcome) return refuse(a, outcome.error());
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

int runSafety(const DemoArguments& a)
{
	const scenes::SafetyOutcome outcome = scenes::runSafety();
	const int presented = present(a, outcome);
	return outcome.ok() ? presented : 1;
}

int runGrasps(const DemoArguments& a)
{
	scenes::GraspReportOptions options;
	options.grasp.cache = a.cache;
	options.grasp.progress = showProgress;
	if (a.meshGiven) options.grasp.mesh = a.mesh;
	options.grasp.file = {a.unit, a.up, a.mass};
	if (a.friction > 0) options.enough = a.friction;
	if (!a.report.empty()) options.maps = std::filesystem::path(a.report).replace_extension().string();
	const auto outcome = scenes::runGraspReport(options);
	if (!outcome) return refuse(a, outcome.error());
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

int runGraspLoad(const DemoArguments& a)
{
	scenes::GraspLoadOptions options;
	options.grasp.object = "duck";
	options.grasp.cache = a.cache;
	options.grasp.progress = showProgress;
	const auto outcome = scenes::runGraspLoad(options);
	if (!outcome) return refuse(a, outcome.error());
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

int runGraspCompare(const DemoArguments& a)
{
	scenes::CarryOptions options;
	options.cache = a.cache;
	options.progress = showProgress;
	const auto outcome = scenes::runCarryReport(options);
	if (!outcome) return refuse(a, outcome.error());
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

int runAssembly(const DemoArguments& a)
{
	scenes::AssemblyOptions options;
	options.build = {a.cache, showProgress, {}};
	options.scenes = a.scenes;
	const auto outcome = scenes::runAssemblyReport(options);
	if (!outcome) return say(outcome.error().message), 1;
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

int runHapticBunny(const DemoArguments& a)
{
	scenes::HapticBunnyOptions options;
	options.mesh = a.mesh;
	options.unit = a.unit;
	options.up = a.up;
	options.spheres = a.spheres;
	options.cache = a.cache;
	options.virtualTime = a.virtualTime;
	options.decoupled = a.decoupled;
	options.worldRate = a.worldRate;
	options.progress = showProgress;
	options.say = say;
	const ist::Result<scenes::HapticBunnyOutcome> outcome = scenes::runHapticBunny(options);
	if (!outcome) return refuse(a, outcome.error());
	const int presented = present(a, outcome.value());
	return outcome.value().ok() ? presented : 1;
}

/// FIELD=VALUE. A value that is no JSON is a text.
ist::Result<scenes::SceneSetting> settingFrom(const std::string& text)
{
	const size_t equals = text.find('=');
	if (equals == 0 || equals == std::string::npos) return ist::Error{"--set wants FIELD=VALUE, not " + text};
	const std::string value = text.substr(equals + 1);
	const ist::ParsedJson parsed = ist::parseJson(value);
	return scenes::SceneSetting{text.substr(0, equals), parsed.ok() ? parsed.value : ist::JsonValue(value)};
}

int runSceneFile(const DemoArguments& a)
{
	std::vector<scenes::SceneSetting> settings;
	for (const std::string& text : a.set)
	{
		ist::Result<scenes::SceneSetting> setting = settingFrom(text);
		if (!setting) return say(setting.error().message), 2;
		settings.push_back(std::move(setting).value());
	}
	const ist::Result<scenes::Scene> scene = scenes::loadScene(a.scene, settings);
	if (!scene) return say(scene.error().message), 1;
	const scenes::SceneRunOptions options{{a.cache, showProgress, say}, a.virtualTime, {}};
	const ist::Result<scenes::SceneOutcome> outcome = scenes::runScene(scene.value(), options);
	if (!outcome) return say(outcome.error().message), 1;
	const int presented = present(a, outcome.value());
	if (outcome.value().interrupted) return 130;
	return outcome.value().ok() ? presented : 1;
}

int runStudyFile(const DemoArguments& a)
{
	const ist::Result<scenes::Study> study = scenes::loadStudy(a.study, a.device);
	if (!study) return say(study.error().message), 1;
	const scenes::StudyRunOptions options{{{a.cache, showProgress, say}, a.virtualTime, {}}, a.participant, a.results};
	std::error_code ignored;  // the study says whether it can write there
	std::filesystem::create_directories(a.results, ignored);
	const ist::Result<scenes::StudyOutcome> outcome = scenes::runStudy(study.value(), options);
	if (!outcome) return say(outcome.error().message), 1;
	scenes::printOutcome(a, outcome.value());
	if (outcome.value().interrupted) return 130;
	return outcome.value().ok() ? 0 : 1;
}

int runPaperFigures(const DemoArguments& a)
{
	std::vector<std::string> files;
	for (const char* name : {"bunny.json", "crown.json", "sword-and-ring.json"})
		files.push_back((std::filesystem::path(a.scenes) / name).string());
	const auto scenes = scenes::runPaperFigures(files, {{a.cache, showProgress, say}, false, {}});
	if (!scenes) return say(scenes.error().message), scenes.error().cancelled ? 130 : 1;
	std::error_code ignored;
	std::filesystem::create_directories(a.paperFigures, ignored);
	const std::filesystem::path folder = a.paperFigures;
	bool written = scenes::writeTextFile((folder / "paper-figures.html").string(), scenes::paperPage(scenes.value()).text());
	for (const scenes::PaperScene& scene : scenes.value())
		written = written && scenes::writeTextFile((folder / (scene.run.scene.name + ".csv")).string(), scenes::paperCsv(scene));
	if (!written) return say("cannot write to " + a.paperFigures), 1;
	scenes::endProgress();
	if (a.json) std::printf("%s\n", scenes::paperJson(scenes.value()).c_str());
	else
		for (const auto& row : scenes::paperRows(scenes.value()))
		{
			std::printf("%-72s", row[0].c_str());
			for (size_t i = 1; i < row.size(); ++i) std::printf(" %12s", row[i].c_str());
			std::printf("\n");
		}
	std::fprintf(stderr, "page: %s\n", (folder / "paper-figures.html").string().c_str());
	for (const scenes::PaperScene& scene : scenes.value())
		if (!scene.run.ok()) return 1;
	return 0;
}

int run(int argc, char** argv)
{
	const DemoArguments a = scenes::parseDemoArguments(argc, argv);
	if (!a.error.empty())
	{
		std::fprintf(stderr, "haptic_demos: %s\n%s", a.error.c_str(), scenes::kDemoUsage);
		return 2;
	}
	if (a.version) return std::puts("haptic_demos " BULLETHAPTICS_VERSION), 0;
	if (a.help) return std::printf("%s", scenes::kDemoUsage), 0;
	if (a.list)
	{
		std::printf("haptic-bunny  a simulated hand feels a body in a Bullet world: press, slide, turn, let go, at 1 kHz\n");
		std::printf("bunny-query   mesh to tree to force: a probe pressed on the bunny and slid over its back\n");
		std::printf("continuity    force from tick to tick while a rod slides, beside that of the continuum\n");
		std::printf("z-width       stiffness and damping of a wall that devices bear, stably and passively\n");
		std::printf("safety        what reaches a device without each stage of the safety chain, and with it\n");
		std::printf("grasps        a hand lifts, turns and shakes six objects, or a --mesh, with friction and without; with --report, heat "
					"maps beside it\n");
		std::printf("grasp-load    time of a tick while a hand of 80,000 spheres holds an object of 10,000\n");
		std::printf("grasp-compare one hand against two, 3 against 6 degrees of freedom: a beam with a nut and a ring on it is carried to "
					"its place\n");
		std::printf("assembly      one hand against two, 3 against 6 degrees of freedom: a peg is carried and put into a tube\n");
		std::printf("of the browser, which opens without --headless:\n");
		scenes::listBrowserDemos();
		return 0;
	}
	std::error_code failed;
	if ((!a.paperFigures.empty() || a.demo == "assembly") && !std::filesystem::is_directory(a.scenes, failed))
		return say("there is no folder " + a.scenes + " here: name that of the scene files by --scenes FOLDER"), 1;
	if (!a.scene.empty()) return runSceneFile(a);
	if (!a.study.empty()) return runStudyFile(a);
	if (!a.paperFigures.empty()) return runPaperFigures(a);
	if (a.demo == "haptic-bunny") return runHapticBunny(a);
	if (a.demo == "continuity") return runContinuity(a);
	if (a.demo == "grasps") return runGrasps(a);
	if (a.demo == "grasp-load") return runGraspLoad(a);
	if (a.demo == "assembly") return runAssembly(a);
	if (a.demo == "grasp-compare") return runGraspCompare(a);
	if (a.demo == "z-width") return runZWidth(a);
	if (a.demo == "safety") return runSafety(a);
	if (a.demo == "bunny-query") return runBunnyQuery(a);
	if (!a.gallery.empty()) return scenes::makeGallery(a);
	if (a.demo.empty()) return scenes::openBrowser(a);
	if (scenes::isBrowserDemo(a.demo)) return a.withoutWindow() ? scenes::runBrowserDemo(a) : scenes::openBrowser(a);
	std::fprintf(stderr, "haptic_demos: no demo is called %s; --list names them\n", a.demo.c_str());
	return 2;
}
}  // namespace

int main(int argc, char** argv)
{
	try
	{
		return run(argc, argv);
	}
	catch (const std::exception& e)
	{
		std::fprintf(stderr, "haptic_demos: %s\n", e.what());
		return 1;
	}
}
