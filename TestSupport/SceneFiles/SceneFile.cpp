// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/SceneFile.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "TestSupport/SceneFiles/SceneReader.h"
#include "TestSupport/SceneFiles/SceneShapes.h"

#include <cmath>
#include <filesystem>
#include <system_error>

using namespace ist;
using Json = ist::JsonValue;

namespace scenes
{
namespace
{
constexpr double kRadians = 3.14159265358979323846 / 180;
}  // namespace

Result<Scene> SceneReader::read(const std::string& name)
{
	m_scene.file = name;
	JsonFields root = fields(m_source.root(), "");
	root.text("$schema");  // for editors
	root.need("schema");
	if (root.number("schema", 1, -1e9, 1e9) != 1) root.refuse("schema", "this program reads schema 1");
	m_scene.name = root.text("name", ist::utf8Path(ist::systemPath(name).stem()));
	m_scene.about = root.text("about");
	m_scene.duration = root.number("duration", 0, 1e-3, kLongestRun);
	m_scene.gravity = root.vector("gravity", m_scene.gravity, 1000);
	readThreads(root);
	root.eachOf("assets", [&](JsonFields& f) { readAsset(f); });
	root.eachOf("materials", [&](JsonFields& f) { readMaterial(f); });
	root.need("bodies");
	root.eachOf("bodies", [&](JsonFields& f) { readBody(f); });
	if (m_scene.bodies.empty()) root.refuse("bodies", "wants at least one");
	readHands(root);
	readWatch(root);
	root.eachOf("hooks", [&](JsonFields& f) { readHook(f); });
	root.finish();
	if (m_problem) return *m_problem;
	return m_scene;
}

std::string SceneReader::placeOf(const JsonFields& f, const std::string& name) const
{
	const std::string text = m_source.problem(f.pathOf(name), "").message;
	return text.substr(0, text.size() - 2);
}

std::string SceneReader::fileName(const std::string& name) const
{
	return name.empty() ? name : ist::utf8Path((ist::systemPath(m_folder) / ist::systemPath(name)).lexically_normal());
}

Pose SceneReader::readPose(JsonFields& f)
{
	const Vec3 turn = f.vector("turn", {}, 360);
	return {rotationMatrix(quaternionFromRotationVector(kRadians * turn)), f.vector("position", {}, kLargestLength)};
}

double SceneReader::length(JsonFields& f, const std::string& name, double otherwise)
{
	return f.number(name, otherwise, kSmallestLength, kLargestLength);
}

void SceneReader::readThreads(JsonFields& root)
{
	const int topology = root.choice("topology", 0, {"one-thread", "contact-in-tick", "contact-thread", "force-thread", "local-model"});
	m_scene.topology = static_cast<SceneTopology>(topology);
	m_scene.worldRate = root.number("worldRate", 60, 1, 1000);
	m_scene.maxPairs = root.whole("maxPairs", -1, 1, int64_t(1) << 40);
	if (m_scene.topology != SceneTopology::OneThread) return;
	for (const char* name : {"worldRate", "maxPairs"})
		if (root.has(name)) root.refuse(name, "goes with the other topologies; with one-thread the world takes a step in each tick");
}

void SceneReader::readAsset(JsonFields& f)
{
	SceneAsset asset;
	asset.place = placeOf(f);
	asset.name = f.newName(m_scene.assets);
	asset.mesh = fileName(f.text("mesh"));
	asset.ist = fileName(f.text("ist"));
	const int kinds = int(f.has("mesh")) + int(f.has("ist")) + int(f.has("shape"));
	if (kinds != 1) f.refuse("", "wants exactly one of mesh, ist and shape");
	if (f.has("mesh"))
	{
		asset.unit = f.number("unit", 0, 1e-9, 1e9);
		asset.longestSide = length(f, "longestSide", 0);
		if (f.has("unit") && f.has("longestSide")) f.refuse("longestSide", "goes without unit");
	}
	if (f.has("shape")) asset.shape = readShape(f);
	if (!f.has("ist"))
	{
		asset.spheres = f.whole("spheres", 10000, 1, 10'000'000);
		asset.seed = static_cast<uint64_t>(f.whole("seed", 1, 0, int64_t(1) << 53));
	}
	m_scene.assets.push_back(std::move(asset));
}

Mesh SceneReader::readShape(JsonFields& f)
{
	const int shape = f.choice("shape", 0, {"box", "sphere", "capsule", "cylinder", "ring", "crown", "sword", "tube"});
	if (shape == 0)
	{
		const Vec3 half = f.vector("halfExtents", {0.05, 0.05, 0.05}, kLargestLength);
		if (!(std::fmin(half.x, std::fmin(half.y, half.z)) >= kSmallestLength))
			f.refuse("halfExtents", "wants three lengths of at least 1e-5");
		return makeBoxMesh(half);
	}
	if (shape == 1) return makeSphereMesh(length(f, "radius", 0.02));
	if (shape == 2 || shape == 3)
	{
		const double radius = length(f, "radius", 0.01), half = length(f, "halfLength", 0.02);
		return shape == 2 ? makeCapsuleMesh(radius, half) : makeCylinderMesh(radius, half);
	}
	if (shape == 4)
	{
		const double radius = length(f, "radius", 0.03), tube = length(f, "tubeRadius", 0.005);
		if (!(tube < radius)) f.refuse("tubeRadius", "wants less than the radius of the ring");
		return makeTorusMesh(radius, tube);
	}
	if (shape == 7) return readTube(f);
	return shape == 5 ? readCrown(f) : makeSwordMesh();
}

Mesh SceneReader::readTube(JsonFields& f)
{
	TubeShape tube;
	tube.radius = length(f, "radius", tube.radius);
	tube.wall = length(f, "wall", tube.wall);
	tube.halfLength = length(f, "halfLength", tube.halfLength);
	tube.chamfer = f.number("chamfer", 0, 0, kLargestLength);
	if (!(tube.wall < tube.radius)) f.refuse("wall", "wants less than the radius");
	if (!(tube.chamfer < tube.wall && tube.chamfer < 2 * tube.halfLength)) f.refuse("chamfer", "wants less than wall and length");
	return m_problem ? Mesh() : makeTubeMesh(tube);
}

Mesh SceneReader::readCrown(JsonFields& f)
{
	CrownShape crown;
	crown.radius = length(f, "radius", crown.radius);
	crown.wall = length(f, "wall", crown.wall);
	crown.bandHeight = length(f, "bandHeight", crown.bandHeight);
	crown.pointHeight = length(f, "pointHeight", crown.pointHeight);
	crown.points = static_cast<int>(f.whole("points", crown.points, 3, 200));
	if (!(crown.wall < crown.radius)) f.refuse("wall", "wants less than the radius");
	return m_problem ? Mesh() : makeCrownMesh(crown);
}

void SceneReader::readMaterial(JsonFields& f)
{
	SceneMaterial material;
	material.name = f.newName(m_materials);
	material.density = f.number("density", material.density, 1e-3, 1e6);
	material.stiffness = f.number("stiffness", 0, 1, 1e15);
	material.dissipation = f.number("dissipation", -1, 0, 1e6);
	material.friction = f.number("friction", material.friction, 0, 100);
	material.rollingFriction = f.number("rollingFriction", 0, 0, 100);
	material.spinningFriction = f.number("spinningFriction", 0, 0, 100);
	m_materials.push_back(material);
}

void SceneReader::readBody(JsonFields& f)
{
	SceneBody body;
	body.place = placeOf(f);
	body.name = f.newName(m_scene.bodies);
	if (int(f.has("asset")) + int(f.has("plane")) + int(f.has("box")) + int(f.has("sphere")) != 1)
		f.refuse("", "wants exactly one of asset, plane, box and sphere");
	if (f.has("asset")) body.asset = find(f, "asset", f.text("asset"), m_scene.assets, "asset");
	if (f.has("material"))
	{
		const size_t material = find(f, "material", f.text("material"), m_materials, "material");
		if (!m_problem) body.material = m_materials[material];
	}
	if (f.has("friction")) body.material.friction = f.number("friction", 0, 0, 100);
	readStockShape(f, body);
	if (body.kind == SceneBody::Kind::Plane)
	{
		body.fixed = true;
		m_scene.bodies.push_back(body);
		return;
	}
	body.X_BM = readPose(f);
	body.mass = f.number("mass", 0, 1e-9, 1e9);
	body.fixed = f.flag("fixed", false);
	if (body.fixed && f.has("mass")) f.refuse("mass", "a fixed body has none");
	m_scene.bodies.push_back(body);
}

void SceneReader::readStockShape(JsonFields& f, SceneBody& body)
{
	if (const Json* plane = f.has("plane") ? f.object("plane") : nullptr)
	{
		body.kind = SceneBody::Kind::Plane;
		JsonFields p = fields(*plane, f.pathOf("plane"));
		body.normal = normalized(p.vector("normal", body.normal, 1e6));
		if (!(norm(body.normal) > 0)) p.refuse("normal", "wants a direction");
		body.offset = p.number("offset", 0, -kLargestLength, kLargestLength);
		p.finish();
	}
	if (f.has("box"))
	{
		body.kind = SceneBody::Kind::Box;
		body.halfExtents = f.vector("box", {}, kLargestLength);
		if (!(std::fmin(body.halfExtents.x, std::fmin(body.halfExtents.y, body.halfExtents.z)) >= kSmallestLength))
			f.refuse("box", "wants three half lengths of at least 1e-5");
	}
	if (f.has("sphere"))
	{
		body.kind = SceneBody::Kind::Sphere;
		body.radius = length(f, "sphere", 1);
	}
}

void SceneReader::readWatch(JsonFields& root)
{
	const Json* pairs = root.list("pairs");
	m_scene.onlyPairs = pairs != nullptr;
	for (size_t i = 0; pairs && i < pairs->size() && !m_problem; ++i) readPair(root, "pairs[" + std::to_string(i) + "]", (*pairs)[i]);
	const Json* region = root.object("region");
	if (!region || m_problem) return;
	JsonFields f = fields(*region, "region");
	f.need("lower");
	f.need("upper");
	Box box{f.vector("lower", {}, kLargestLength), f.vector("upper", {}, kLargestLength)};
	for (int i = 0; i < 3; ++i)
		if (!(box.lower[i] <= box.upper[i])) f.refuse("upper", "wants nothing below the lower corner");
	f.finish();
	m_scene.region = box;
}

/// Reads a pair of bodies, or of a body and a hand that has parts.
void SceneReader::readPair(JsonFields& root, const std::string& at, const Json& pair)
{
	if (!pair.isList() || pair.size() != 2 || !pair[0].isText() || !pair[1].isText())
	{
		root.refuse(at, "wants the names of two bodies");
		return;
	}
	for (int side = 0; side < 2; ++side)
		for (size_t hand = 0; hand < m_scene.hands.size(); ++hand)
			if (m_scene.hands[hand].parts && m_scene.hands[hand].name == pair[size_t(side)].text())
			{
				m_scene.partPairs.push_back({hand, find(root, at, pair[size_t(1 - side)].text(), m_scene.bodies, "body")});
				return;
			}
	const size_t a = find(root, at, pair[0].text(), m_scene.bodies, "body");
	const size_t b = find(root, at, pair[1].text(), m_scene.bodies, "body");
	if (a == b) root.refuse(at, "wants two different bodies");
	m_scene.pairs.push_back({a, b});
}

namespace
{
Result<Scene> readScene(
	Result<JsonSource> source, const std::string& name, const std::string& folder, const std::vector<SceneSetting>& settings)
{
	if (!source) return source.error();
	for (const auto& [path, value] : settings)
		if (const auto refused = source.value().replace(path, value)) return Error{name + ": " + refused->message};
	return SceneReader(source.value(), folder).read(name);
}
}  // namespace

Result<Scene> parseScene(
	const std::string& name, const std::string& text, const std::string& folder, const std::vector<SceneSetting>& settings)
{
	return readScene(JsonSource::parse(name, text), name, folder, settings);
}

Result<Scene> loadScene(const std::string& path, const std::vector<SceneSetting>& settings)
{
	return readScene(JsonSource::load(path), path, ist::utf8Path(ist::systemPath(path).parent_path()), settings);
}
}  // namespace scenes
