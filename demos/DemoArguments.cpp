// SPDX-License-Identifier: Zlib
#include "demos/DemoArguments.h"

#include "BulletISTCollision/Core/Mesh/LengthUnit.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <vector>

namespace scenes
{
const char* const kDemoUsage =
	"usage: haptic_demos [--demo NAME] [options] | --list | --version | --scene FILE [options] | --study FILE --participant N [options] | "
	"--paper-figures DIR | --gallery DIR\n"
	"without a demo, or with one of the browser's and without --headless, a window opens\n"
	"  --scene FILE     run a scene file (data/scenes); of the options below, those of the mesh and the world do not go with it\n"
	"  --set FIELD=VALUE of --scene, as often as you like: a field and what it is in place of the file's, as topology=contact-in-tick or "
	"hand.device=sim:touchx\n"
	"  --study FILE     run the trials of a study (data/studies) with --participant N, its number from 1\n"
	"  --device ADDRESS of --study: the device in place of that of the scenes\n"
	"  --results FOLDER where --study writes its two CSV files, made where it is missing (default: the current folder)\n"
	"  --paper-figures DIR  rates of force and contact of three scenes, in real time: a page and CSV files\n"
	"  --scenes FOLDER  where --paper-figures and --demo assembly find their scenes (default data/scenes, from the current folder)\n"
	"  --mesh FILE      mesh to use (default: the bunny of glmark2-data; of the browser's demos, a shape of their own)\n"
	"  --unit UNIT      unit of the file, in place of the one that it states: m, cm, mm, um, in, ft, or metres (default: the longest side "
	"becomes 0.2 m; of --demo grasps, 0.1 m)\n"
	"  --up AXIS        the file's axis that points up, which becomes y: z or -x, or z,y with another axis to become\n"
	"  --mass KG, --friction MU  of the mesh of --demo grasps (default 0.15 and 0.5)\n"
	"  --spheres N      spheres to pack (default 10000)\n"
	"  --cache DIR      where trees are kept for the next run (default: the current folder; \"\": nowhere)\n"
	"  --virtual-time   as fast as possible and reproducible, instead of at 1 kHz\n"
	"  --decoupled      the world steps on its own, in its own thread; haptic-bunny only\n"
	"  --world-rate HZ  at this rate (default 60)\n"
	"  --report FILE    write a report as one HTML file\n"
	"  --json           print the result as JSON instead of a table\n"
	"  --headless       no window (only the browser and its demos open one; --list says which those are)\n"
	"of the browser's demos:\n"
	"  --frames N       so many steps; of the window: so many pictures until it closes itself\n"
	"  --dt S           seconds a step (default: what the demo thinks right)\n"
	"  --economy off|E  query every pair in every step, or reuse contacts where the force error stays below E (default 0.05; 0: only "
	"where it adds none)\n"
	"  --force-error E  query the coarsest level whose force error stays within this share, 0 (default: always the leaves) to 1\n"
	"  --beside-stock   two halves: the same with Bullet's own contact on the left\n"
	"  --show LIST      in pictures and the window, besides what the demo shows: "
	"spheres,sphere-levels,leaves,levels,lenses,pairs,boxes,frames,wireframe; no-meshes, no-forces ... hide\n"
	"  --screenshot FILE   a PNG of the end, without a window or a display\n"
	"  --record FOLDER  30 numbered PNG for each second of the demo's time, from its beginning; an empty or a new folder\n"
	"  --save-scene FILE   the bodies at the end as a scene file (--scene FILE), with their trees beside it\n"
	"  --window-screenshot FILE  of the window's last picture, with --frames\n"
	"  --size WxH       of pictures (default 960x540) or of the window (1280x800)\n"
	"  --device ADDRESS a device that moves what the hand of the window holds (`devicebridge list` shows addresses)\n"
	"  --forces         the hand at that device feels the tool, in a thread of 1 kHz of its own\n"
	"  --gallery DIR    a picture of every demo and a page that shows them\n";

namespace
{
const std::vector<std::string> kOfTheBrowser = {"--frames", "--dt", "--screenshot", "--record", "--size", "--gallery",
	"--window-screenshot", "--device", "--economy", "--force-error", "--beside-stock", "--show", "--save-scene", "--forces"};

/// The whole of `text` as a positive finite number, else 0.
double positiveNumber(const std::string& text)
{
	char* end = nullptr;
	const double value = std::strtod(text.c_str(), &end);
	return end != text.c_str() && *end == 0 && std::isfinite(value) && value > 0 ? value : 0;
}
/// What was given and does not go with the rest; empty: nothing.
std::string conflict(const std::set<std::string>& given, const DemoArguments& a)
{
	const auto clash = [&](const std::string& with, const std::vector<std::string>& without, const std::string& why) {
		for (const std::string& name : without)
			if (given.count(name)) return with + " goes without " + name + ": " + why;
		return std::string();
	};
	const bool grasps = a.demo == "grasps" || a.demo == "grasp-load" || a.demo == "grasp-compare" || a.demo == "assembly";
	const bool others = given.count("--scene") || given.count("--study") || given.count("--paper-figures") || a.demo == "haptic-bunny" ||
		a.demo == "bunny-query" || a.demo == "continuity" || grasps;
	std::vector<std::string> foreign = kOfTheBrowser;
	if (given.count("--study")) foreign.erase(std::find(foreign.begin(), foreign.end(), "--device"));
	if (others)
		if (std::string wrong = clash(given.count("--scene") ? "--scene"
					: given.count("--study")                 ? "--study"
					: a.demo.empty()                         ? "--paper-figures"
															 : "--demo " + a.demo,
				foreign, "only the browser's demos know it");
			!wrong.empty())
			return wrong;
	if (!others)
		if (std::string wrong = clash("the browser", {"--unit", "--mass", "--friction", "--virtual-time", "--decoupled", "--world-rate"},
				"its demos scale their meshes and step as they are drawn");
			!wrong.empty())
			return wrong;
	if (!others && a.demo.empty() && !given.count("--gallery"))
		for (const char* name : {"--headless", "--json", "--report", "--screenshot", "--record", "--save-scene"})
			if (given.count(name))
				return std::string(name) +
					" needs --demo NAME or --scene FILE: without either the browser opens in a window (--list names the demos)";
	if (given.count("--forces") && !given.count("--device")) return "--forces goes with --device ADDRESS, where they are felt";
	if (given.count("--device") && !given.count("--study"))
		for (const char* name : {"--headless", "--json", "--report", "--screenshot", "--record", "--save-scene", "--gallery"})
			if (given.count(name))
				return std::string("--device goes without ") + name +
					": it moves the hand of the window; without a window a device leads the hand of a scene file (--scene FILE --set "
					"hand.device=ADDRESS --set hand.path=[] --set duration=SECONDS)";
	if (given.count("--window-screenshot") && !given.count("--frames")) return "--window-screenshot goes with --frames";
	if (given.count("--paper-figures"))
		return clash("--paper-figures",
			{"--scene", "--demo", "--mesh", "--unit", "--spheres", "--virtual-time", "--decoupled", "--world-rate", "--report"},
			"it runs its own scenes in real time and writes its own page");
	if (!given.count("--mesh") || a.demo != "grasps")
		for (const char* name : {"--mass", "--friction"})
			if (given.count(name)) return std::string(name) + " goes with --demo grasps --mesh FILE";
	if (given.count("--up") && !given.count("--mesh")) return "--up goes with --mesh";
	if (given.count("--scenes") && a.demo != "assembly") return "--scenes goes with --paper-figures and --demo assembly";
	if (given.count("--study"))
	{
		if (!given.count("--participant")) return "--study needs --participant N, which decides the order of the conditions";
		return clash("--study", {"--scene", "--demo", "--mesh", "--unit", "--spheres", "--decoupled", "--world-rate", "--report"},
			"the file says all that, and the results are two CSV files");
	}
	if (given.count("--set") && !given.count("--scene")) return "--set goes with --scene";
	for (const char* name : {"--participant", "--results"})
		if (given.count(name)) return std::string(name) + " goes with --study";
	if (given.count("--scene"))
		return clash("--scene", {"--demo", "--mesh", "--unit", "--spheres", "--decoupled", "--world-rate"}, "the file says all that");
	if (a.demo == "continuity")
		return clash("--demo continuity", {"--unit", "--virtual-time", "--decoupled", "--world-rate"},
			"its longest side is 0.2 m, and it has neither clock nor world");
	if (a.demo == "grasps")
		return clash("--demo grasps", {"--spheres", "--virtual-time", "--decoupled", "--world-rate"},
			"it has its own bodies, or one mesh, and no clock");
	if (grasps)
		return clash("--demo " + a.demo, {"--mesh", "--unit", "--spheres", "--virtual-time", "--decoupled", "--world-rate"},
			"it has its own bodies, and no clock");
	if (a.demo == "z-width" || a.demo == "safety")
		return clash("--demo " + a.demo, {"--mesh", "--unit", "--spheres", "--virtual-time", "--decoupled", "--world-rate"},
			"it has neither bodies nor clock");
	return {};
}

/// From 1 to 1e9, else 0 and an error.
long long integerArgument(const std::string& option, const std::string& text, DemoArguments& a)
{
	const double count = positiveNumber(text);
	if (count >= 1 && count <= 1e9 && count == std::floor(count)) return static_cast<long long>(count);
	a.error = option + " must be a positive whole number, not " + text;
	return 0;
}

void readBrowserNumbers(const std::string& frames, const std::string& dt, const std::string& size, DemoArguments& a)
{
	if (!dt.empty() && !((a.dt = positiveNumber(dt)) > 0 && a.dt <= 1))
		a.error = "--dt must be a positive number of seconds, at most 1, not " + dt;
	if (!frames.empty()) a.frames = integerArgument("--frames", frames, a);
	if (size.empty()) return;
	a.sizeGiven = true;
	const size_t cross = size.find('x');
	const double width = positiveNumber(size.substr(0, cross)),
				 height = cross == std::string::npos ? 0 : positiveNumber(size.substr(cross + 1));
	if (!(width >= 16 && width <= 8192 && height >= 16 && height <= 8192))
		a.error = "--size must be like 960x540, 16 to 8192 each, not " + size;
	else a.width = int(width), a.height = int(height);
}

void readForceError(const std::string& share, DemoArguments& a)
{
	if (share.empty()) return;
	a.forceError = positiveNumber(share);
	if (share != "0" && !(a.forceError > 0 && a.forceError <= 1)) a.error = "--force-error must be a number from 0 to 1, not " + share;
}

void readContactCache(const std::string& contactCache, DemoArguments& a)
{
	if (contactCache.empty()) return;
	a.contactCache = contactCache != "off";
	a.maxError = a.contactCache ? positiveNumber(contactCache) : 0;
	if (a.contactCache && contactCache != "0" && !(a.maxError > 0 && a.maxError <= 0.5))
		a.error = "--economy must be off or a number from 0 to 0.5, not " + contactCache;
}
}  // namespace

DemoArguments parseDemoArguments(int argc, char** argv)
{
	DemoArguments a;
	std::string unit, up, mass, friction, spheres, worldRate, participant, frames, dt, size, contactCache, forceError;
	std::set<std::string> given;
	const std::map<std::string, bool*> flags = {{"--list", &a.list}, {"--version", &a.version}, {"--help", &a.help}, {"-h", &a.help},
		{"--json", &a.json}, {"--headless", &a.headless}, {"--virtual-time", &a.virtualTime}, {"--decoupled", &a.decoupled},
		{"--beside-stock", &a.besideStock}, {"--forces", &a.forces}};
	const std::map<std::string, std::string*> values = {{"--demo", &a.demo}, {"--scene", &a.scene}, {"--study", &a.study},
		{"--participant", &participant}, {"--results", &a.results}, {"--paper-figures", &a.paperFigures}, {"--mesh", &a.mesh},
		{"--report", &a.report}, {"--cache", &a.cache}, {"--scenes", &a.scenes}, {"--unit", &unit}, {"--up", &up}, {"--mass", &mass},
		{"--friction", &friction}, {"--spheres", &spheres}, {"--world-rate", &worldRate}, {"--frames", &frames}, {"--dt", &dt},
		{"--size", &size}, {"--economy", &contactCache}, {"--force-error", &forceError}, {"--screenshot", &a.screenshot},
		{"--record", &a.record}, {"--gallery", &a.gallery}, {"--window-screenshot", &a.windowScreenshot}, {"--device", &a.device},
		{"--show", &a.show}, {"--save-scene", &a.saveScene}};
	for (int i = 1; i < argc && a.error.empty(); ++i)
	{
		const std::string name = argv[i];
		given.insert(name);
		const auto flag = flags.find(name);
		const auto value = values.find(name);
		if (flag != flags.end()) *flag->second = true;
		else if (value == values.end() && name != "--set") a.error = "unknown option " + name;
		else if (i + 1 == argc) a.error = name + " needs a value";
		else if (name == "--set") a.set.push_back(argv[++i]);
		else if (*value->second = argv[++i]; value->second->empty() && name != "--cache")
			a.error = name + " needs a value";  // without a cache nothing is kept
	}
	if (!a.error.empty()) return a;
	a.error = conflict(given, a);
	if (!a.error.empty()) return a;
	a.unit = ist::lengthUnit(unit).value_or(0);
	if (!unit.empty() && !(a.unit > 0)) a.error = "--unit must be m, cm, mm, um, in, ft, or a positive number of metres, not " + unit;
	a.up = ist::upAxes(up);
	if (!up.empty() && !a.up) a.error = "--up must be an axis like z or -x, or two like z,y, not " + up;
	a.mass = positiveNumber(mass);
	if (!mass.empty() && !(a.mass >= 1e-3 && a.mass <= 10)) a.error = "--mass must be a number of kg from 0.001 to 10, not " + mass;
	a.friction = positiveNumber(friction);
	if (!friction.empty() && !(a.friction >= 0.05 && a.friction <= 5))
		a.error = "--friction must be a number from 0.05 to 5, not " + friction;
	if (!worldRate.empty()) a.worldRate = positiveNumber(worldRate);
	if (!(a.worldRate >= 1 && a.worldRate <= 1000)) a.error = "--world-rate must be between 1 and 1000 Hz, not " + worldRate;
	if (!worldRate.empty() && !a.decoupled) a.error = "--world-rate goes with --decoupled";
	if (!participant.empty()) a.participant = static_cast<int>(integerArgument("--participant", participant, a));
	readBrowserNumbers(frames, dt, size, a);
	readContactCache(contactCache, a);
	readForceError(forceError, a);
	a.meshGiven = given.count("--mesh") > 0;
	a.spheresGiven = !spheres.empty();
	if (spheres.empty()) return a;
	a.spheres = integerArgument("--spheres", spheres, a);
	return a;
}
}  // namespace scenes
