// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/SceneReader.h"

#include <algorithm>
#include <cmath>

using namespace ist;
using Json = ist::JsonValue;

namespace scenes
{
void SceneReader::readHands(JsonFields& root)
{
	m_scene.handPlace = placeOf(root, "hand");
	if (root.has("hand") && root.has("hands")) root.refuse("hands", "goes without hand, which is a list of one");
	if (const Json* object = root.object("hand"))
	{
		JsonFields f = fields(*object, "hand");
		readHand(f);
		f.finish();
	}
	root.eachOf("hands", [&](JsonFields& f) {
		f.need("name");
		readHand(f);
	});
	if (m_scene.hands.empty() || m_problem) return;
	if (m_scene.duration == 0)
		for (const SceneHand& hand : m_scene.hands)
			if (!hand.path.empty()) m_scene.duration = std::max(m_scene.duration, hand.path.back().time);
	if (m_scene.duration == 0) root.refuse("duration", "is missing, and no hand has a path to say how long it moves");
}

void SceneReader::readHand(JsonFields& f)
{
	SceneHand hand;
	hand.place = placeOf(f);
	hand.name = f.text("name", hand.name);
	for (const SceneHand& other : m_scene.hands)
		if (other.name == hand.name) f.refuse("name", "another one is called " + hand.name + " already");
	f.need("device");
	hand.device = f.text("device");
	hand.devicePlace = placeOf(f, "device");
	if (hand.device.find(':') == std::string::npos)
		f.refuse("device", "wants an address such as sim:sigma7; devicebridge list shows what can be had");
	if (f.has("parts")) readParts(f, hand);
	else readTool(f, hand);
	if (const Json* origin = f.object("origin"))
	{
		JsonFields o = fields(*origin, f.pathOf("origin"));
		hand.X_BW = readPose(o);
		o.finish();
	}
	if (!m_problem) m_scene.hands.push_back(std::move(hand));
}

void SceneReader::readTool(JsonFields& f, SceneHand& hand)
{
	f.need("tool");
	hand.tool = find(f, "tool", f.text("tool"), m_scene.bodies, "body");
	if (!m_problem)
	{
		const SceneBody& tool = m_scene.bodies[hand.tool];
		if (tool.kind != SceneBody::Kind::Asset) f.refuse("tool", "wants a body with an asset; " + tool.name + " has none");
		if (tool.fixed) f.refuse("tool", tool.name + " is fixed and cannot follow a hand");
		for (const SceneHand& other : m_scene.hands)
			if (!other.parts && other.tool == hand.tool) f.refuse("tool", other.name + " holds " + tool.name + " already");
	}
	hand.toolGravity = f.flag("gravity", false);
	if (const Json* coupling = f.object("coupling")) readCoupling(fields(*coupling, f.pathOf("coupling")), hand.coupling);
	f.eachOf("path", [&](JsonFields& frame) { readKeyFrame(frame, hand); });
}

void SceneReader::readParts(JsonFields& f, SceneHand& hand)
{
	if (f.has("tool")) f.refuse("tool", "goes without parts, which are the tool");
	if (m_scene.topology != SceneTopology::OneThread)
		f.refuse("parts", "the bodies of a tracked hand are in the world, which its thread steps: they want the topology one-thread");
	for (const SceneBody& body : m_scene.bodies)
		if (body.name == hand.name) f.refuse("name", "a body is called " + hand.name + ", and pairs name both");
	const Json* object = f.object("parts");
	if (!object) return;
	JsonFields parts = fields(*object, f.pathOf("parts"));
	hand.parts.emplace();
	hand.parts->spheres = parts.whole("spheres", hand.parts->spheres, 1, 100'000);
	hand.parts->friction = parts.number("friction", hand.parts->friction, 0, 100);
	parts.finish();
}

void SceneReader::readCoupling(JsonFields f, SceneCoupling& c)
{
	c.isStatic = f.flag("static", false);
	c.stiffness = f.number("stiffness", -1, 0, 1e6);
	c.angularStiffness = f.number("angularStiffness", -1, 0, 1e6);
	c.damping = f.number("damping", -1, 0, 1e4);
	c.angularDamping = f.number("angularDamping", -1, 0, 1e4);
	c.maxForce = f.number("maxForce", -1, 0, 1e4);
	c.maxTorque = f.number("maxTorque", -1, 0, 1e4);
	c.softContact = f.number("softContact", 1, 1, 1e3);
	f.finish();
}

void SceneReader::readKeyFrame(JsonFields& f, SceneHand& hand)
{
	SceneKeyFrame frame;
	f.need("time");
	frame.time = f.number("time", 0, 0, kLongestRun);
	if (!hand.path.empty() && !(frame.time > hand.path.back().time)) f.refuse("time", "wants more than that of the frame before");
	frame.X_BM = readPose(f);
	const Json* buttons = f.list("buttons");
	for (size_t i = 0; buttons && i < buttons->size(); ++i)
	{
		const double number = (*buttons)[i].isNumber() ? (*buttons)[i].number() : 0;
		if (!(number >= 1 && number <= kMostButtons && number == std::floor(number)))
			return f.refuse("buttons", "wants numbers of buttons, from 1 to 32");
		frame.buttons |= 1u << (static_cast<unsigned>(number) - 1);
	}
	hand.path.push_back(frame);
}
}  // namespace scenes
