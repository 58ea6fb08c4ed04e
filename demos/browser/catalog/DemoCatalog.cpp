// SPDX-License-Identifier: Zlib
#include "demos/browser/catalog/DemoCatalog.h"

#include <algorithm>
#include <cctype>
#include <sstream>

// Each line is one demo: its function, name, group, and one sentence about it.
#define BROWSER_DEMOS(demo) \
	demo(makeHello, "hello", "First steps", "Two rings on a plane, one lying, one falling: the whole library in one file") demo( \
		makePacking, "packing", "First steps", \
		"Any mesh, or one that is dropped on the window, is filled with spheres, the largest first") demo(makeDial, "dial", "First steps", \
		"The error that you accept, against what is promised, what is true, and what it costs: turn it") demo(makeBunny, "bunny", \
		"To be felt", "A steel ball presses on a soft body and slides over it; the mouse takes the ball in six degrees of freedom") \
		demo(makeCrown, "crown", "To be felt", "A glass plate on the sixteen thin points of a crown") demo( \
			makeSword, "sword", "To be felt", "A sword falls through a ring and hangs in it by its guard") demo(makePeg, "peg", \
			"To be felt", "A peg falls, tilted, into a hole that is hardly wider") demo(makeGrasp, "grasp", "Mechanisms", \
			"A hand of sixteen parts lifts a mug, and paints where each finger touched it") demo(makePile, "pile", "Mechanisms", \
			"A hand presses on a pile of concave bodies in a tray, rakes through it and comes to rest on it") \
			demo(makeGears, "gears", "Mechanisms", "A gear drives another one against a load, tooth by tooth") \
				demo(makeScrew, "screw", "Mechanisms", "A screw runs down its nut under its own weight; a rough one locks itself") demo( \
					makeStack, "stack", "Stability", "A stack of rings with a knot on top: no body is convex") demo(makeHeavyOnLight, \
					"heavy-on-light", "Stability", "A thousand kilograms stand on one kilogram at 60 Hz") demo(makeStockAgainstOurs, \
					"stock-against-ours", "Stability", "The same cubes in stock Bullet and beside it in ours, from the same start") \
					demo(makeShapes, "shapes", "Stability", "The same body on each of Bullet's own shapes") demo( \
						makeScales, "scales", "Laws of physics", "The same fall from a millimetre to a kilometre, with nothing set") \
						demo(makeIncline, "incline", "Laws of physics", "Two slabs on a slope, one rough and one smooth, as Coulomb says") \
							demo(makeFloating, "floating", "Laws of physics", "A log, a ball and a knot in water, as Archimedes says") \
								demo(makeEnergy, "energy", "Laws of physics", "Bodies bounce until they lie, and every joule has a name")

namespace browser
{
#define DECLARE_DEMO(make, name, group, about) std::unique_ptr<BrowsableDemo> make();
BROWSER_DEMOS(DECLARE_DEMO)

namespace
{
std::string lowered(std::string text)
{
	std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
	return text;
}
}  // namespace

const std::vector<DemoEntry>& demoCatalog()
{
#define LIST_DEMO(make, name, group, about) {name, group, about, make},
	static const std::vector<DemoEntry> catalog = {BROWSER_DEMOS(LIST_DEMO)};
	return catalog;
}

const DemoEntry* findDemo(const std::string& name)
{
	for (const DemoEntry& entry : demoCatalog())
		if (name == entry.name) return &entry;
	return nullptr;
}

std::vector<const DemoEntry*> searchDemos(const std::string& text)
{
	std::vector<const DemoEntry*> found;
	for (const DemoEntry& entry : demoCatalog())
	{
		const std::string all = lowered(std::string(entry.name) + " " + entry.group + " " + entry.about);
		std::istringstream words(lowered(text));
		bool fits = true;
		for (std::string word; words >> word;) fits = fits && all.find(word) != std::string::npos;
		if (fits) found.push_back(&entry);
	}
	return found;
}
}  // namespace browser
