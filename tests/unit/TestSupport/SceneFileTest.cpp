// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/SceneFile.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

using namespace ist;
using namespace scenes;

namespace
{
/// One field a line, so that a test can name the line.
const char* const kWhole = R"({
	"schema": 1,
	"name": "all of it",
	"about": "words",
	"duration": 2.5,
	"gravity": [0, 0, -1.6],
	"topology": "local-model",
	"worldRate": 90,
	"maxPairs": 5000,
	"assets": [
		{"name": "a", "mesh": "sub/a.obj", "unit": 0.01, "spheres": 100, "seed": 7},
		{"name": "b", "mesh": "b.obj", "longestSide": 0.3},
		{"name": "c", "ist": "c.ist"},
		{"name": "ball", "shape": "sphere", "radius": 0.02, "spheres": 50}
	],
	"materials": [
		{"name": "wood", "density": 700, "stiffness": 1e7, "dissipation": 3, "friction": 0.6, "rollingFriction": 0.02, "spinningFriction": 0.01}
	],
	"bodies": [
		{"name": "floor", "plane": {"normal": [0, 0, 2], "offset": -0.5}, "friction": 0.9},
		{"name": "one", "asset": "a", "material": "wood", "position": [1, 2, 3], "turn": [0, 90, 0], "mass": 4},
		{"name": "two", "asset": "c", "fixed": true},
		{"name": "crate", "box": [0.1, 0.2, 0.3]},
		{"name": "pea", "sphere": 0.01},
		{"name": "tool", "asset": "ball", "material": "wood"}
	],
	"hand": {
		"device": "sim:omega6",
		"tool": "tool",
		"gravity": true,
		"origin": {"position": [0, 0, 1], "turn": [0, 0, 45]},
		"coupling": {"stiffness": 500, "angularStiffness": 0.1, "damping": 1, "angularDamping": 0.001, "maxForce": 5, "maxTorque": 0.05,)"
						   R"("softContact": 4},
		"path": [
			{"time": 0, "position": [0, 0, 1]},
			{"time": 1, "position": [0, 0, 2], "turn": [10, 0, 0]}
		]
	},
	"pairs": [["tool", "one"], ["one", "floor"]],
	"region": {"lower": [-1, -2, -3], "upper": [1, 2, 3]},
	"hooks": [
		{"on": "transform", "do": "record", "file": "poses.csv"},
		{"on": "collision", "do": "count"},
		{"on": "haptic-tick", "do": "force", "force": [0, 0, 1]},
		{"on": "haptic-tick", "do": "damping", "damping": 2, "angularDamping": 0.01},
		{"on": "haptic-tick", "do": "scale", "factor": 0.5},
		{"on": "fault", "do": "log"},
		{"on": "fault", "do": "stop"}
	]
})";

std::string with(const std::string& from, const std::string& to)
{
	std::string text = kWhole;
	const size_t at = text.find(from);
	EXPECT_NE(at, std::string::npos) << from;
	return text.replace(at, from.size(), to);
}

std::string refusalOf(const std::string& text)
{
	const Result<Scene> scene = parseScene("s.json", text, "/data");
	return scene ? "accepted" : scene.error().message;
}
}  // namespace

TEST(SceneFile, ReadsSceneAndAssets)
{
	const Result<Scene> read = parseScene("s.json", kWhole, "/data");
	ASSERT_TRUE(read) << read.error().message;
	const Scene& s = read.value();
	EXPECT_EQ(s.name, "all of it");
	EXPECT_EQ(s.about, "words");
	EXPECT_EQ(s.duration, 2.5);
	EXPECT_EQ(s.gravity, (Vec3{0, 0, -1.6}));
	EXPECT_EQ(s.topology, SceneTopology::LocalModel);
	EXPECT_EQ(s.worldRate, 90);
	EXPECT_EQ(s.maxPairs, 5000);
	ASSERT_EQ(s.assets.size(), 4u);
	EXPECT_EQ(s.assets[0].mesh, "/data/sub/a.obj");
	EXPECT_EQ(s.assets[0].unit, 0.01);
	EXPECT_EQ(s.assets[0].spheres, 100);
	EXPECT_EQ(s.assets[0].seed, 7u);
	EXPECT_EQ(s.assets[1].longestSide, 0.3);
	EXPECT_EQ(s.assets[1].spheres, 10000);
	EXPECT_EQ(s.assets[2].ist, "/data/c.ist");
	EXPECT_NEAR(bounds(s.assets[3].shape).upper.x, 0.02, 1e-4);
	EXPECT_EQ(s.assets[3].place, "s.json:14: assets[3]");
}

TEST(SceneFile, ReadsBodiesHandAndHooks)
{
	const Result<Scene> read = parseScene("s.json", kWhole, "/data");
	ASSERT_TRUE(read) << read.error().message;
	const Scene& s = read.value();
	ASSERT_EQ(s.bodies.size(), 6u);
	EXPECT_EQ(s.bodies[0].kind, SceneBody::Kind::Plane);
	EXPECT_EQ(s.bodies[0].normal, (Vec3{0, 0, 1}));
	EXPECT_EQ(s.bodies[0].offset, -0.5);
	EXPECT_EQ(s.bodies[0].material.friction, 0.9);
	EXPECT_TRUE(s.bodies[0].fixed);
	EXPECT_EQ(s.bodies[1].asset, 0u);
	EXPECT_EQ(s.bodies[1].mass, 4);
	EXPECT_EQ(s.bodies[1].material.density, 700);
	EXPECT_EQ(s.bodies[1].material.stiffness, 1e7);
	EXPECT_EQ(s.bodies[1].material.dissipation, 3);
	EXPECT_EQ(s.bodies[1].material.friction, 0.6);
	EXPECT_EQ(s.bodies[1].material.rollingFriction, 0.02);
	EXPECT_EQ(s.bodies[1].material.spinningFriction, 0.01);
	// A quarter turn about y takes z to x.
	EXPECT_LT(distance(s.bodies[1].X_BM * Vec3{0, 0, 1}, {2, 2, 3}), 1e-12);
	EXPECT_EQ(s.bodies[2].asset, 2u);
	EXPECT_TRUE(s.bodies[2].fixed);
	EXPECT_EQ(s.bodies[3].halfExtents, (Vec3{0.1, 0.2, 0.3}));
	EXPECT_EQ(s.bodies[4].radius, 0.01);

	ASSERT_EQ(s.hands.size(), 1u);
	const SceneHand& hand = s.hands[0];
	EXPECT_EQ(hand.name, "hand");
	EXPECT_EQ(hand.device, "sim:omega6");
	EXPECT_EQ(hand.tool, 5u);
	EXPECT_TRUE(hand.toolGravity);
	ASSERT_TRUE(hand.X_BW.has_value());
	EXPECT_LT(distance(*hand.X_BW * Vec3{1, 0, 0}, {std::sqrt(0.5), std::sqrt(0.5), 1}), 1e-12);
	EXPECT_EQ(hand.coupling.stiffness, 500);
	EXPECT_EQ(hand.coupling.angularStiffness, 0.1);
	EXPECT_EQ(hand.coupling.damping, 1);
	EXPECT_EQ(hand.coupling.angularDamping, 0.001);
	EXPECT_EQ(hand.coupling.maxForce, 5);
	EXPECT_EQ(hand.coupling.maxTorque, 0.05);
	EXPECT_EQ(hand.coupling.softContact, 4);
	ASSERT_EQ(hand.path.size(), 2u);
	EXPECT_EQ(hand.path[1].time, 1);
	EXPECT_EQ(hand.path[1].X_BM.translation, (Vec3{0, 0, 2}));

	EXPECT_TRUE(s.onlyPairs);
	ASSERT_EQ(s.pairs.size(), 2u);
	EXPECT_EQ(s.pairs[0], (std::pair<size_t, size_t>(5, 1)));
	EXPECT_EQ(s.pairs[1], (std::pair<size_t, size_t>(1, 0)));
	ASSERT_TRUE(s.region.has_value());
	EXPECT_EQ(s.region->lower, (Vec3{-1, -2, -3}));
	ASSERT_EQ(s.hooks.size(), 7u);
	EXPECT_EQ(s.hooks[0].file, "/data/poses.csv");
	EXPECT_EQ(s.hooks[2].force, (Vec3{0, 0, 1}));
	EXPECT_EQ(s.hooks[3].damping, 2);
	EXPECT_EQ(s.hooks[3].angularDamping, 0.01);
	EXPECT_EQ(s.hooks[4].factor, 0.5);
	EXPECT_EQ(s.hooks[6].action, SceneHook::Action::Stop);
}

TEST(SceneFile, EveryMistakeIsRefusedWithLineAndField)
{
	struct Mistake
	{
		const char *from, *to, *wanted;
	};
	const Mistake mistakes[] = {
		{"\"schema\": 1", "\"schema\": 2", "s.json:2: schema: this program reads schema 1"},
		{"\"schema\": 1,", "", "s.json:1: schema: is missing"},
		{"\"duration\": 2.5", "\"duration\": \"long\"", "s.json:5: duration: wants a number from"},
		{"\"duration\": 2.5", "\"duration\": 1e999", "s.json:5: not JSON: number overflow"},
		{"\"duration\": 2.5", "\"duration\": -1", "s.json:5: duration: wants a number from"},
		{"[0, 0, -1.6]", "[0, 0]", "s.json:6: gravity: wants three numbers"},
		{"[0, 0, -1.6]", "[0, 0, null]", "s.json:6: gravity: wants three numbers"},
		{"\"local-model\"", "\"remote\"", "s.json:7: topology: wants one of one-thread, "},
		{"\"local-model\"", "\"one-thread\"", "s.json:8: worldRate: goes with the other topologies"},
		{"\"worldRate\": 90", "\"worldRate\": 0", "s.json:8: worldRate: wants a number from 1"},
		{"\"maxPairs\": 5000", "\"maxPairs\": 2.5", "s.json:9: maxPairs: wants a whole number"},
		{"\"maxPairs\": 5000", "\"maxPair\": 5000",
			"s.json:9: maxPair: no such field is known here; known ones are $schema, about, assets"},
		{"\"unit\": 0.01", "\"unit\": 0", "s.json:11: assets[0].unit: wants a number from"},
		{"\"unit\": 0.01", "\"unit\": 0.01, \"longestSide\": 1", "s.json:11: assets[0].longestSide: goes without unit"},
		{"\"mesh\": \"sub/a.obj\"", "\"mesh\": \"\"", "s.json:11: assets[0].mesh: wants a text in quotes"},
		{"\"mesh\": \"b.obj\"", "\"mesh\": \"b.obj\", \"ist\": \"b.ist\"",
			"s.json:12: assets[1]: wants exactly one of mesh, ist and shape"},
		{"\"name\": \"b\"", "\"name\": \"a\"", "s.json:12: assets[1].name: another one is called a already"},
		{"\"ist\": \"c.ist\"", "\"ist\": \"c.ist\", \"spheres\": 5", "s.json:13: assets[2].spheres: no such field is known here"},
		{"\"shape\": \"sphere\"", "\"shape\": \"cow\"", "s.json:14: assets[3].shape: wants one of box, sphere"},
		{"\"radius\": 0.02", "\"radius\": 1e-9", "s.json:14: assets[3].radius: wants a number from 1e-05"},
		{"\"shape\": \"sphere\", \"radius\": 0.02", "\"shape\": \"ring\", \"radius\": 0.02, \"tubeRadius\": 0.03",
			"s.json:14: assets[3].tubeRadius: wants less"},
		{"\"shape\": \"sphere\", \"radius\": 0.02", "\"shape\": \"crown\", \"radius\": 0.02, \"wall\": 0.03",
			"s.json:14: assets[3].wall: wants less"},
		{"\"shape\": \"sphere\", \"radius\": 0.02", "\"shape\": \"box\", \"halfExtents\": [1, 0, 1]",
			"s.json:14: assets[3].halfExtents: wants three lengths"},
		{"\"stiffness\": 1e7", "\"stiffness\": -5", "s.json:17: materials[0].stiffness: wants a number from"},
		{"\"friction\": 0.6", "\"friction\": \"much\"", "s.json:17: materials[0].friction: wants a number from"},
		{"\"normal\": [0, 0, 2]", "\"normal\": [0, 0, 0]", "s.json:20: bodies[0].plane.normal: wants a direction"},
		{"\"plane\": {", "\"plane\": {\"tilt\": 1, ", "s.json:20: bodies[0].plane.tilt: no such field is known here"},
		{"\"plane\": {\"normal\": [0, 0, 2], \"offset\": -0.5}", "\"plane\": 3", "s.json:20: bodies[0].plane: wants an object in braces"},
		{"\"asset\": \"a\"", "\"asset\": \"z\"", "s.json:21: bodies[1].asset: no asset is called z; there are a, b, c, ball"},
		{"\"material\": \"wood\", \"position\"", "\"material\": \"tin\", \"position\"",
			"s.json:21: bodies[1].material: no material is called tin; there are wood"},
		{"\"mass\": 4", "\"mass\": 0", "s.json:21: bodies[1].mass: wants a number from"},
		{"\"mass\": 4", "\"mass\": 4, \"mass\": 5", "s.json:21: bodies[1].mass: stands there twice"},
		{"\"mass\": 4", "\"mass\": 4, \"fixed\": true", "s.json:21: bodies[1].mass: a fixed body has none"},
		{"\"fixed\": true", "\"fixed\": 1", "s.json:22: bodies[2].fixed: wants true or false"},
		{"\"box\": [0.1, 0.2, 0.3]", "\"box\": [0.1, 0.2, -0.3]", "s.json:23: bodies[3].box: wants three half lengths"},
		{"\"box\": [0.1, 0.2, 0.3]", "\"weight\": 2", "s.json:23: bodies[3]: wants exactly one of asset, plane, box and sphere"},
		{"\"sphere\": 0.01}", "\"sphere\": null}", "s.json:24: bodies[4].sphere: wants a number from"},
		{"\"device\": \"sim:omega6\"", "\"device\": \"omega6\"", "s.json:28: hand.device: wants an address such as sim:sigma7"},
		{"\"tool\": \"tool\",", "\"tool\": \"floor\",", "s.json:29: hand.tool: wants a body with an asset; floor has none"},
		{"\"tool\": \"tool\",", "\"tool\": \"two\",", "s.json:29: hand.tool: two is fixed"},
		{"\"tool\": \"tool\",", "", "s.json:27: hand.tool: is missing"},
		{"\"tool\": \"tool\",", "\"tol\": \"tool\",", "s.json:29: hand.tol: no such field is known here; is tool meant?"},
		{"\"turn\": [0, 0, 45]", "\"turn\": 45", "s.json:31: hand.origin.turn: wants three numbers"},
		{"\"softContact\": 4", "\"softContact\": 0.5", "s.json:32: hand.coupling.softContact: wants a number from"},
		{"\"maxForce\": 5", "\"maxForce\": -5", "s.json:32: hand.coupling.maxForce: wants a number from"},
		{"\"time\": 1,", "\"time\": 0,", "s.json:35: hand.path[1].time: wants more than that of the frame before"},
		{"{\"time\": 0, \"position\": [0, 0, 1]}", "7", "s.json:34: hand.path[0]: wants an object in braces"},
		{"[\"tool\", \"one\"]", "[\"tool\", \"ghost\"]", "s.json:38: pairs[0]: no body is called ghost; there are floor, one"},
		{"[\"tool\", \"one\"]", "[\"tool\"]", "s.json:38: pairs[0]: wants the names of two bodies"},
		{"[\"tool\", \"one\"]", "[\"one\", \"one\"]", "s.json:38: pairs[0]: wants two different bodies"},
		{"\"upper\": [1, 2, 3]", "\"upper\": [1, -3, 3]", "s.json:39: region.upper: wants nothing below the lower corner"},
		{"\"lower\": [-1, -2, -3], ", "", "s.json:39: region.lower: is missing"},
		{", \"file\": \"poses.csv\"", "", "s.json:41: hooks[0].file: is missing"},
		{"\"file\": \"poses.csv\"", "\"file\": \"./sub/x/../a.obj\"", "s.json:41: hooks[0].file: is that of the asset a"},
		{"\"do\": \"scale\", \"factor\": 0.5", "\"do\": \"record\", \"file\": \"sub/../poses.csv\"",
			"s.json:45: hooks[4].file: another hook records into it"},
		{"\"on\": \"collision\"", "\"on\": \"tuesday\"", "s.json:42: hooks[1].on: wants one of transform, collision, haptic-tick, fault"},
		{"\"on\": \"collision\"", "\"on\": \"fault\"", "s.json:42: hooks[1].do: count cannot be done on fault"},
		{"\"force\": [0, 0, 1]", "\"force\": [0, 0, 1e9]", "s.json:43: hooks[2].force: wants three numbers of at most 100"},
		{"\"factor\": 0.5", "\"factor\": 0.5, \"gain\": 1", "s.json:45: hooks[4].gain: no such field is known here"},
		{"\"hooks\": [", "\"hooks\": {} , \"x\": [", "s.json:40: hooks: wants a list in brackets"},
		{"\"bodies\": [", "\"corpses\": [", "s.json:1: bodies: is missing"},
		{"\"bodies\": [", "\"bodies\": [], \"corpses\": [", "s.json:19: bodies: wants at least one"},
		{"\"about\": \"words\",", "\"about\": \"words\"", "s.json:5: not JSON: "},
	};
	for (const Mistake& m : mistakes)
	{
		const std::string refusal = refusalOf(with(m.from, m.to));
		EXPECT_EQ(refusal.compare(0, std::string(m.wanted).size(), m.wanted), 0) << "wanted " << m.wanted << "\n   got " << refusal;
	}
}

namespace
{
/// Two hands with a tool each, and a tracked hand.
const char* const kHands = R"({
	"schema": 1,
	"assets": [{"name": "ball", "shape": "sphere"}],
	"bodies": [
		{"name": "floor", "plane": {}},
		{"name": "a", "asset": "ball"},
		{"name": "b", "asset": "ball"}
	],
	"hands": [
		{"name": "left", "device": "sim:sigma7", "tool": "a", "path": [{"time": 0}, {"time": 3}]},
		{"name": "right", "device": "sim:touch", "tool": "b", "path": [{"time": 0}, {"time": 2}], "coupling": {"stiffness": 300}},
		{"name": "glove", "device": "motion:hand.csv", "parts": {"spheres": 60, "friction": 0.4}, "origin": {"position": [0, 1, 0]}}
	],
	"pairs": [["a", "b"], ["floor", "glove"]],
	"hooks": [{"on": "collision", "do": "count", "hand": "right"}, {"on": "fault", "do": "log"}]
})";

std::string refusalOfHands(const std::string& from, const std::string& to)
{
	std::string text = kHands;
	const size_t at = text.find(from);
	EXPECT_NE(at, std::string::npos) << from;
	return refusalOf(text.replace(at, from.size(), to));
}
}  // namespace

TEST(SceneFile, ReadsSeveralHands)
{
	const Result<Scene> read = parseScene("s.json", kHands, "");
	ASSERT_TRUE(read) << read.error().message;
	const Scene& s = read.value();
	ASSERT_EQ(s.hands.size(), 3u);
	EXPECT_EQ(s.hands[0].name, "left");
	EXPECT_EQ(s.hands[0].tool, 1u);
	EXPECT_EQ(s.hands[0].path.size(), 2u);
	EXPECT_LT(s.hands[0].coupling.stiffness, 0);
	EXPECT_EQ(s.hands[1].device, "sim:touch");
	EXPECT_EQ(s.hands[1].devicePlace, "s.json:11: hands[1].device");
	EXPECT_EQ(s.hands[1].coupling.stiffness, 300);
	ASSERT_TRUE(s.hands[2].parts.has_value());
	EXPECT_EQ(s.hands[2].parts->spheres, 60);
	EXPECT_EQ(s.hands[2].parts->friction, 0.4);
	EXPECT_EQ(s.hands[2].X_BW->translation.y, 1);
	EXPECT_EQ(s.duration, 3);
	EXPECT_FALSE(s.isTool(0));
	EXPECT_TRUE(s.isTool(1));
	EXPECT_TRUE(s.isTool(2));
	EXPECT_EQ(s.pairs, (std::vector<std::pair<size_t, size_t>>{{1, 2}}));
	EXPECT_EQ(s.partPairs, (std::vector<std::pair<size_t, size_t>>{{2, 0}}));
	EXPECT_EQ(s.hooks[0].hand, 1u);
	EXPECT_FALSE(s.hooks[1].hand.has_value());
}

TEST(SceneFile, EveryMistakeInSeveralHandsIsRefusedWithLineAndField)
{
	const struct
	{
		const char *from, *to, *wanted;
	} mistakes[] = {
		{"\"hands\": [", "\"hand\": {}, \"hands\": [", "s.json:9: hands: goes without hand"},
		{"\"name\": \"left\", ", "", "s.json:10: hands[0].name: is missing"},
		{"\"name\": \"right\"", "\"name\": \"left\"", "s.json:11: hands[1].name: another one is called left already"},
		{"\"tool\": \"b\"", "\"tool\": \"a\"", "s.json:11: hands[1].tool: left holds a already"},
		{"\"tool\": \"b\", ", "", "s.json:11: hands[1].tool: is missing"},
		{"\"stiffness\": 300", "\"stiffness\": -1", "s.json:11: hands[1].coupling.stiffness: wants a number from"},
		{"{\"time\": 2}", "{\"time\": 0}", "s.json:11: hands[1].path[1].time: wants more than that of the frame before"},
		{"\"parts\": {", "\"tool\": \"b\", \"parts\": {", "s.json:12: hands[2].tool: goes without parts"},
		{"\"parts\": {", "\"gravity\": true, \"parts\": {", "s.json:12: hands[2].gravity: no such field is known here"},
		{"\"spheres\": 60", "\"spheres\": 0", "s.json:12: hands[2].parts.spheres: wants a number from 1"},
		{"\"friction\": 0.4", "\"slip\": 0.4", "s.json:12: hands[2].parts.slip: no such field is known here"},
		{"\"name\": \"glove\"", "\"name\": \"floor\"", "s.json:12: hands[2].name: a body is called floor"},
		{"\"schema\": 1,", "\"schema\": 1, \"topology\": \"local-model\",", "s.json:12: hands[2].parts: the bodies of a tracked hand"},
		{"[\"floor\", \"glove\"]", "[\"ghost\", \"glove\"]", "s.json:14: pairs[1]: no body is called ghost"},
		{"[\"floor\", \"glove\"]", "[\"floor\", \"left\"]", "s.json:14: pairs[1]: no body is called left"},
		{"\"hand\": \"right\"", "\"hand\": \"both\"", "s.json:15: hooks[0].hand: no hand is called both; there are left, right, glove"},
	};
	EXPECT_EQ(refusalOf(kHands), "accepted");
	for (const auto& m : mistakes)
	{
		const std::string refusal = refusalOfHands(m.from, m.to);
		EXPECT_EQ(refusal.compare(0, std::string(m.wanted).size(), m.wanted), 0) << "wanted " << m.wanted << "\n   got " << refusal;
	}
}

TEST(SceneFile, ReadsSwitches)
{
	std::string text = kHands;
	const std::string from = R"({"on": "fault", "do": "log"})";
	text.replace(text.find(from), from.size(), R"(
		{"on": "button", "do": "switch", "what": "friction"},
		{"on": "button", "button": 3, "when": "released", "do": "switch", "what": "coupling", "to": "on", "hand": "left"},
		{"on": "collision", "body": "floor", "when": "ends", "do": "switch", "what": "pair", "pair": ["b", "a"], "to": "off", "start": "off"},
		{"on": "collision", "do": "switch", "what": "pair", "pair": ["glove", "floor"]},
		{"on": "button", "button": 32, "do": "stop"},
		{"on": "collision", "do": "count", "body": "b"})");
	const std::string path = R"({"time": 2})";
	text.replace(text.find(path), path.size(), R"({"time": 2, "buttons": [1, 32]})");
	const Result<Scene> read = parseScene("s.json", text, "");
	ASSERT_TRUE(read) << read.error().message;
	const std::vector<SceneHook>& hooks = read.value().hooks;
	ASSERT_EQ(hooks.size(), 7u);
	EXPECT_EQ(hooks[1].event, SceneHook::Event::Button);
	EXPECT_EQ(hooks[1].action, SceneHook::Action::Switch);
	EXPECT_EQ(hooks[1].button, 1);
	EXPECT_FALSE(hooks[1].atEnd);
	EXPECT_EQ(hooks[1].what, SceneHook::What::Friction);
	EXPECT_EQ(hooks[1].to, SceneHook::To::Toggle);
	EXPECT_FALSE(hooks[1].startsOff);
	EXPECT_EQ(hooks[2].button, 3);
	EXPECT_TRUE(hooks[2].atEnd);
	EXPECT_EQ(hooks[2].what, SceneHook::What::Coupling);
	EXPECT_EQ(hooks[2].to, SceneHook::To::On);
	EXPECT_EQ(hooks[2].hand, 0u);
	EXPECT_EQ(hooks[3].body, 0u);
	EXPECT_TRUE(hooks[3].atEnd);
	EXPECT_EQ(hooks[3].pair, 0u);
	EXPECT_EQ(hooks[3].to, SceneHook::To::Off);
	EXPECT_TRUE(hooks[3].startsOff);
	EXPECT_EQ(hooks[4].partPair, 0u);
	EXPECT_EQ(hooks[5].button, 32);
	EXPECT_EQ(hooks[6].body, 2u);
	EXPECT_EQ(read.value().hands[1].path[1].buttons, 0x80000001u);
}

TEST(SceneFile, EveryMistakeInASwitchIsRefusedWithLineAndField)
{
	const struct
	{
		const char *hook, *wanted;
	} mistakes[] = {
		{R"({"on": "button", "do": "count"})", "do: count cannot be done on button"},
		{R"({"on": "fault", "do": "switch", "what": "forces"})", "do: switch cannot be done on fault"},
		{R"({"on": "button", "button": 0, "do": "stop"})", "button: wants a number from 1"},
		{R"({"on": "button", "when": "begins", "do": "stop"})", "when: wants one of pressed, released"},
		{R"({"on": "collision", "when": "pressed", "do": "switch", "what": "forces"})", "when: wants one of begins, ends"},
		{R"({"on": "collision", "body": "ghost", "do": "stop"})", "body: no body is called ghost"},
		{R"({"on": "button", "do": "switch"})", "what: is missing"},
		{R"({"on": "button", "do": "switch", "what": "gravity"})", "what: wants one of friction, coupling, forces, pair"},
		{R"({"on": "button", "do": "switch", "what": "forces", "to": "half"})", "to: wants one of toggle, on, off"},
		{R"({"on": "button", "do": "switch", "what": "forces", "start": 1})", "start: wants a text in quotes"},
		{R"({"on": "button", "do": "switch", "what": "forces", "pair": ["a", "b"]})", "pair: no such field is known here"},
		{R"({"on": "button", "do": "switch", "what": "pair"})", "pair: is missing"},
		{R"({"on": "button", "do": "switch", "what": "pair", "pair": ["a"]})", "pair: wants the names of two bodies"},
		{R"({"on": "button", "do": "switch", "what": "pair", "pair": ["a", "floor"]})", "pair: wants one of the pairs"},
		{R"({"on": "button", "do": "switch", "what": "coupling"})", "what: glove has parts"},
	};
	for (const auto& m : mistakes)
	{
		const std::string refusal = refusalOfHands(R"({"on": "fault", "do": "log"})", m.hook),
						  wanted = std::string("s.json:15: hooks[1].") + m.wanted;
		EXPECT_EQ(refusal.compare(0, wanted.size(), wanted), 0) << "wanted " << wanted << "\n   got " << refusal;
	}
	EXPECT_EQ(refusalOfHands("{\"time\": 2}", "{\"time\": 2, \"buttons\": [0]}")
				  .find("s.json:11: hands[1].path[1].buttons: wants numbers of buttons"),
		0u);
	std::string text = kHands;
	const std::string stiff = "\"stiffness\": 300", log = R"({"on": "fault", "do": "log"})";
	text.replace(text.find(stiff), stiff.size(), "\"static\": true");
	text.replace(text.find(log), log.size(), R"({"on": "button", "do": "switch", "what": "coupling", "hand": "right"})");
	EXPECT_EQ(refusalOf(text).find("s.json:15: hooks[1].what: the coupling of right is static"), 0u) << refusalOf(text);
}

TEST(SceneFile, WithoutADurationThePathGivesIt)
{
	const Result<Scene> scene = parseScene("s.json", with("\t\"duration\": 2.5,\n", ""), "");
	ASSERT_TRUE(scene) << scene.error().message;
	EXPECT_EQ(scene.value().duration, 1);
}

TEST(SceneFile, ASceneForTestsHasNoHand)
{
	const Result<Scene> whole = parseScene("s.json", kWhole, "");
	ASSERT_TRUE(whole) << whole.error().message;
	EXPECT_EQ(whole.value().hands.size(), 1u);
	EXPECT_EQ(whole.value().handPlace, "s.json:27: hand");
	const Result<Scene> scene = parseScene("s.json", R"({"schema": 1, "bodies": [{"name": "pea", "sphere": 0.01}]})", "");
	ASSERT_TRUE(scene) << scene.error().message;
	EXPECT_TRUE(scene.value().hands.empty());
	EXPECT_EQ(scene.value().handPlace, "s.json:1: hand");
}

TEST(SceneFile, ARecordingDoesNotTakeThePlaceOfItsScene)
{
	const Result<Scene> scene = parseScene("./data/s.json", with("poses.csv", "sub/../s.json"), "./data");
	ASSERT_FALSE(scene);
	EXPECT_EQ(scene.error().message, "./data/s.json:41: hooks[0].file: is the scene file itself");
}

// The same file by its absolute name, through a link to it, and through a link to its folder; what shall be recorded need not be there yet.
TEST(SceneFile, ARecordingIsKnownByItsFileAndNotByItsName)
{
	namespace fs = std::filesystem;
	const fs::path folder = "scene-file-names";
	fs::remove_all(folder);
	fs::create_directories(folder / "sub");
	for (const char* name : {"s.json", "c.ist", "b.obj", "sub/a.obj"}) std::ofstream(folder / name) << "kept\n";
	fs::create_symlink("..", folder / "sub" / "up");
	for (const char* name : {"s.json", "c.ist", "b.obj"}) fs::create_symlink(name, folder / (std::string("link to ") + name));
	fs::create_hard_link(folder / "b.obj", folder / "twin.obj");

	const std::string relative = folder.string(), absolute = fs::absolute(folder).string(),
					  place = relative + "/s.json:41: hooks[0].file: ";
	const auto refusal = [&](const std::string& from, const std::string& to) {
		const Result<Scene> scene = parseScene(relative + "/s.json", with(from, to), relative);
		return scene ? "accepted" : scene.error().message;
	};
	EXPECT_EQ(refusal("poses.csv", "poses.csv"), "accepted");
	EXPECT_EQ(refusal("poses.csv", absolute + "/poses.csv"), "accepted");
	for (const std::string& way : {absolute + "/", std::string("link to "), std::string("sub/up/")})
	{
		EXPECT_EQ(refusal("poses.csv", way + "s.json"), place + "is the scene file itself");
		EXPECT_EQ(refusal("poses.csv", way + "c.ist"), place + "is that of the asset c");
		EXPECT_EQ(refusal("poses.csv", way + "b.obj"), place + "is that of the asset b");
	}
	EXPECT_EQ(refusal("poses.csv", "twin.obj"), place + "is that of the asset b");
	for (const std::string& way : {absolute + "/", std::string("sub/up/")})
		EXPECT_EQ(refusal("\"do\": \"scale\", \"factor\": 0.5", "\"do\": \"record\", \"file\": \"" + way + "poses.csv\""),
			relative + "/s.json:45: hooks[4].file: another hook records into it already");
	fs::remove_all(folder);
}

TEST(SceneFile, AByteOrderMarkIsPassedOver)
{
	EXPECT_EQ(refusalOf(std::string("\xEF\xBB\xBF") + kWhole), "accepted");
	const std::string refusal = refusalOf("\xEF\xBB\xBF" + with("\"mass\": 4", "\"mass\": 0"));
	EXPECT_EQ(refusal.find("s.json:21: bodies[1].mass: wants a number from"), 0u) << refusal;
}

TEST(SceneFile, CutAndDamagedFilesAreRefusedInASentence)
{
	const std::string whole = kWhole;
	for (size_t length = 0; length < whole.size(); length += 7)
	{
		const std::string refusal = refusalOf(whole.substr(0, length));
		EXPECT_EQ(refusal.compare(0, 7, "s.json:"), 0) << length << ": " << refusal;
	}
	// Whatever single bytes become: an answer, and nothing but a scene or a sentence with file and line.
	std::mt19937 random(4);
	for (int i = 0; i < 3000; ++i)
	{
		std::string broken = whole;
		for (int n = 0; n < 3; ++n) broken[random() % broken.size()] = static_cast<char>(random() % 256);
		const std::string refusal = refusalOf(broken);
		EXPECT_TRUE(refusal == "accepted" || refusal.compare(0, 7, "s.json:") == 0) << refusal;
	}
	EXPECT_EQ(refusalOf(std::string(100000, '[')).compare(0, 7, "s.json:"), 0);
	EXPECT_EQ(refusalOf(std::string(100, '[') + std::string(100, ']')).find("is nested too deeply") != std::string::npos, true);
	EXPECT_EQ(refusalOf("[]"), "s.json:1: wants an object in braces");
}

TEST(SceneFile, AFileThatIsNotThereIsNamed)
{
	const Result<Scene> scene = loadScene("no/such/scene.json");
	ASSERT_FALSE(scene);
	EXPECT_EQ(scene.error().message, "no/such/scene.json: cannot be read");
	const Result<Scene> folder = loadScene(SCENE_FOLDER);
	ASSERT_FALSE(folder);
	EXPECT_EQ(folder.error().message, std::string(SCENE_FOLDER) + ": cannot be read");
}

TEST(SceneFile, SettingsTakeThePlaceOfFields)
{
	const auto with = [](const std::string& path, const JsonValue& value) { return parseScene("s.json", kWhole, "", {{path, value}}); };
	EXPECT_EQ(with("gravity", JsonValue::list({1, 2, 3})).value().gravity, (Vec3{1, 2, 3}));
	const Result<Scene> other = with("bodies[1].asset", "b");
	ASSERT_TRUE(other) << other.error().message;
	EXPECT_EQ(other.value().bodies[1].asset, 1u);
	EXPECT_EQ(other.value().bodies[1].mass, 4);
	EXPECT_EQ(other.value().bodies[2].asset, 2u);
	EXPECT_EQ(with("bodies[2].friction", 0.25).value().bodies[2].material.friction, 0.25);  // a field that the file lacks
	EXPECT_EQ(parseScene("s.json", kWhole, "", {{"bodies[1].asset", "b"}, {"bodies[1].mass", 5}}).value().bodies[1].mass, 5);

	const auto refusal = [&](const std::string& path, const JsonValue& value) {
		const Result<Scene> scene = with(path, value);
		return scene ? "accepted" : scene.error().message;
	};
	EXPECT_EQ(refusal("bodies[1].asset", "z"), "s.json:21: bodies[1].asset: no asset is called z; there are a, b, c, ball");
	EXPECT_EQ(refusal("bodies[1]", JsonValue{{"nmae", "one"}}).compare(0, 10, "s.json:21:"), 0);
	EXPECT_EQ(refusal("bodies[9].asset", "a"), "s.json: \"bodies[9].asset\" is an element that is not there");
	EXPECT_EQ(refusal("schema.version", 1), "s.json: \"schema.version\" is a field of what is no object");
	for (const char* path :
		{"", ".", "bodies[", "bodies[]", "bodies[-1]", "bodies[1", "bodies[1.]", "bodies[999999999999]", "a..b", "bodies.[0]"})
		EXPECT_NE(refusal(path, 1).find("\"" + std::string(path) + "\" is "), std::string::npos) << path << ": " << refusal(path, 1);
	std::string deep = "a";
	for (int i = 0; i < 100000; ++i) deep += ".a";
	EXPECT_NE(refusal(deep, 1), "accepted");
}

TEST(SceneFile, TheScenesThatAreCarriedAreWhole)
{
	int found = 0;
	for (const auto& entry : std::filesystem::directory_iterator(SCENE_FOLDER))
	{
		if (entry.path().extension() != ".json" || entry.path().stem().extension() == ".schema") continue;
		const Result<Scene> scene = loadScene(entry.path().string());
		EXPECT_TRUE(scene) << scene.error().message;
		++found;
	}
	EXPECT_GE(found, 5);
}
