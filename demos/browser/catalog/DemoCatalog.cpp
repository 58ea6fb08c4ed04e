// SPDX-License-Identifier: Zlib
#include "demos/browser/catalog/DemoCatalog.h"

#include <algorithm>
#include <cctype>
#include <sstream>

namespace browser
{
std::unique_ptr<BrowsableDemo> makeHello(), makePacking(), makeDial(), makeBunny(), makeCrown(), makeSword(), makePeg(), makeGrasp(),
	makePile(), makeGears(), makeScrew(), makeStack(), makeHeavyOnLight(), makeStockAgainstOurs(), makeShapes(), makeScales(),
	makeIncline(), makeFloating(), makeEnergy();

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
	static const std::vector<DemoEntry> catalog = {
		{"hello", "First steps", "Two rings on a plane, one lying, one falling: the whole library in one file", makeHello},
		{"packing", "First steps", "Any mesh, or one that is dropped on the window, is filled with spheres, the largest first",
			makePacking},
		{"dial", "First steps",
			"You set the force error that you accept; charts show the error bound, the true error and the cost, and the error of a motion "
			"for each step",
			makeDial},
		{"bunny", "To be felt",
			"A steel ball presses on a soft body and slides over it; the mouse takes the ball in six degrees of freedom", makeBunny},
		{"crown", "To be felt", "A glass plate on the sixteen thin points of a crown", makeCrown},
		{"sword", "To be felt", "A sword falls through a ring and hangs in it by its guard", makeSword},
		{"peg", "To be felt", "A peg falls, tilted, into a hole that is hardly wider", makePeg},
		{"grasp", "Mechanisms", "A hand of sixteen parts lifts a mug, and paints where each finger touched it", makeGrasp},
		{"pile", "Mechanisms", "A hand presses on a pile of concave bodies in a tray, rakes through it and comes to rest on it", makePile},
		{"gears", "Mechanisms", "A gear drives another one against a load, tooth by tooth", makeGears},
		{"screw", "Mechanisms", "A screw runs down its nut under its own weight; a rough one locks itself", makeScrew},
		{"stack", "Stability", "A stack of rings with a knot on top: no body is convex", makeStack},
		{"heavy-on-light", "Stability", "A thousand kilograms stand on one kilogram at 60 Hz", makeHeavyOnLight},
		{"stock-against-ours", "Stability", "The same cubes in stock Bullet and beside it in ours, from the same start",
			makeStockAgainstOurs},
		{"shapes", "Stability", "The same body on each of Bullet's own shapes", makeShapes},
		{"scales", "Laws of physics", "The same fall from a millimetre to a kilometre, with nothing set", makeScales},
		{"incline", "Laws of physics", "Two slabs on a slope, one rough and one smooth, as Coulomb says", makeIncline},
		{"floating", "Laws of physics", "A log, a ball and a knot in water, as Archimedes says", makeFloating},
		{"energy", "Laws of physics", "Bodies bounce until they lie, and every joule has a name", makeEnergy},
	};
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
