// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/SceneFile.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "TestSupport/SceneFiles/JsonSource.h"
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
constexpr double kLargestLength = 1000;   // [m]
constexpr double kSmallestLength = 1e-5;  // [m]
constexpr double kLongestRun = 3600;      // [s]
constexpr double kRadians = 3.14159265358979323846 / 180;

/// True when two names mean one file, however they are spelled, also through links. The file need not exist.
bool isSameFile(const std::string& a, const std::string& b)
{
	if (a.empty() || b.empty()) return false;
	namespace fs = std::filesystem;
	std::error_code failed;
	if (fs::equivalent(a, b, failed)) return true;
	const fs::path left = fs::weakly_canonical(fs::absolute(a, failed), failed),
				   right = fs::weakly_canonical(fs::absolute(b, failed), failed);
	return a == b || (!left.empty() && left == right);
}

class SceneReader
{
public:
	SceneReader(const JsonSource& source, std::string folder) : m_source(source), m_folder(std::move(folder)) {}

	Result<Scene> read(const std::string& name)
	{
		m_scene.file = name;
		JsonFields root = fields(m_source.root(), "");
		root.need("schema");
		if (root.number("schema", 1, -1e9, 1e9) != 1) root.refuse("schema", "this program reads schema 1");
		m_scene.name = root.text("name", std::filesystem::path(name).stem().string());
		m_scene.about = root.text("about");
		m_scene.duration = root.number("duration", 0, 1e-3, kLongestRun);
		m_scene.gravity = root.vector("gravity", m_scene.gravity, 1000);
		readThreads(root);
		eachOf(root, "assets", [&](JsonFields& f, size_t) { readAsset(f); });
		eachOf(root, "materials", [&](JsonFields& f, size_t) { readMaterial(f); });
		root.need("bodies");
		eachOf(root, "bodies", [&](JsonFields& f, size_t) { readBody(f); });
		if (m_scene.bodies.empty()) root.refuse("bodies", "wants at least one");
		readHand(root);
		readWatch(root);
		eachOf(root, "hooks", [&](JsonFields& f, size_t) { readHook(f); });
		root.finish();
		if (m_problem) return *m_problem;
		return m_scene;
	}

private:
	JsonFields fields(const Json& object, const std::string& path) { return JsonFields(m_source, object, path, m_problem); }

	/// Reads every object of a list, and refuses unknown fields in each.
	template <class Read> void eachOf(JsonFields& parent, const std::string& name, const Read& read)
	{
		const Json* list = parent.list(name);
		for (size_t i = 0; list && i < list->size() && !m_problem; ++i)
		{
			JsonFields each = fields((*list)[i], parent.pathOf(name) + "[" + std::to_string(i) + "]");
			read(each, i);
			each.finish();
		}
	}

	std::string placeOf(const JsonFields& f, const std::string& name = {}) const
	{
		const std::string text = m_source.problem(f.pathOf(name), "").message;
		return text.substr(0, text.size() - 2);
	}

	/// Index of a name among the objects read so far.
	template <class Named>
	size_t find(JsonFields& f, const std::string& field, const std::string& wanted, const std::vector<Named>& all, const char* kind)
	{
		std::string known;
		for (size_t i = 0; i < all.size(); ++i)
		{
			if (all[i].name == wanted) return i;
			known += (i ? ", " : "") + all[i].name;
		}
		f.refuse(field, std::string("no ") + kind + " is called " + wanted + (known.empty() ? "; there is none" : "; there are " + known));
		return 0;
	}

	template <class Named> std::string newName(JsonFields& f, const std::vector<Named>& all)
	{
		f.need("name");
		const std::string name = f.text("name");
		for (const Named& other : all)
			if (other.name == name) f.refuse("name", "another one is called " + name + " already");
		return name;
	}

	std::string fileName(const std::string& name) const
	{
		return name.empty() ? name : (std::filesystem::path(m_folder) / name).lexically_normal().string();
	}

	Pose readPose(JsonFields& f)
	{
		const Vec3 turn = f.vector("turn", {}, 360);
		return {rotationMatrix(quaternionFromRotationVector(kRadians * turn)), f.vector("position", {}, kLargestLength)};
	}

	double length(JsonFields& f, const std::string& name, double otherwise)
	{
		return f.number(name, otherwise, kSmallestLength, kLargestLength);
	}

	void readThreads(JsonFields& root)
	{
		const int topology = root.choice("topology", 0, {"one-thread", "contact-in-tick", "contact-thread", "force-thread", "local-model"});
		m_scene.topology = static_cast<SceneTopology>(topology);
		m_scene.worldRate = root.number("worldRate", 60, 1, 1000);
		m_scene.maxPairs = root.whole("maxPairs", -1, 1, int64_t(1) << 40);
		if (m_scene.topology != SceneTopology::OneThread) return;
		for (const char* name : {"worldRate", "maxPairs"})
			if (root.has(name)) root.refuse(name, "goes with the other topologies; with one-thread the world takes a step in each tick");
	}

	void readAsset(JsonFields& f)
	{
		SceneAsset asset;
		asset.place = placeOf(f);
		asset.name = newName(f, m_scene.assets);
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

	Mesh readShape(JsonFields& f)
	{
		const int shape = f.choice("shape", 0, {"box", "sphere", "capsule", "cylinder", "ring", "crown", "sword"});
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
		return shape == 5 ? readCrown(f) : makeSwordMesh();
	}

	Mesh readCrown(JsonFields& f)
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

	void readMaterial(JsonFields& f)
	{
		SceneMaterial material;
		material.name = newName(f, m_materials);
		material.density = f.number("density", material.density, 1e-3, 1e6);
		material.stiffness = f.number("stiffness", 0, 1, 1e15);
		material.dissipation = f.number("dissipation", -1, 0, 1e6);
		material.friction = f.number("friction", material.friction, 0, 100);
		m_materials.push_back(material);
	}

	void readBody(JsonFields& f)
	{
		SceneBody body;
		body.place = placeOf(f);
		body.name = newName(f, m_scene.bodies);
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

	void readStockShape(JsonFields& f, SceneBody& body)
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

	void readHand(JsonFields& root)
	{
		m_scene.handPlace = placeOf(root, "hand");
		const Json* object = root.object("hand");
		if (!object || m_problem) return;
		m_scene.hasHand = true;
		JsonFields f = fields(*object, "hand");
		f.need("device");
		f.need("tool");
		m_scene.device = f.text("device");
		m_scene.devicePlace = placeOf(f, "device");
		if (m_scene.device.find(':') == std::string::npos)
			f.refuse("device", "wants an address such as sim:sigma7; devicebridge list shows what can be had");
		m_scene.tool = find(f, "tool", f.text("tool"), m_scene.bodies, "body");
		if (!m_problem) checkTool(f);
		m_scene.toolGravity = f.flag("gravity", false);
		if (const Json* origin = f.object("origin"))
		{
			JsonFields o = fields(*origin, "hand.origin");
			m_scene.X_BW = readPose(o);
			o.finish();
		}
		if (const Json* coupling = f.object("coupling")) readCoupling(*coupling);
		eachOf(f, "path", [&](JsonFields& frame, size_t) { readKeyFrame(frame); });
		f.finish();
		if (m_scene.duration == 0 && !m_scene.path.empty()) m_scene.duration = m_scene.path.back().time;
		if (m_scene.duration == 0) root.refuse("duration", "is missing, and the hand has no path to say how long it moves");
	}

	void checkTool(JsonFields& f)
	{
		const SceneBody& tool = m_scene.bodies[m_scene.tool];
		if (tool.kind != SceneBody::Kind::Asset) f.refuse("tool", "wants a body with an asset; " + tool.name + " has none");
		if (tool.fixed) f.refuse("tool", tool.name + " is fixed and cannot follow a hand");
	}

	void readCoupling(const Json& object)
	{
		JsonFields f = fields(object, "hand.coupling");
		SceneCoupling& c = m_scene.coupling;
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

	void readKeyFrame(JsonFields& f)
	{
		SceneKeyFrame frame;
		f.need("time");
		frame.time = f.number("time", 0, 0, kLongestRun);
		if (!m_scene.path.empty() && !(frame.time > m_scene.path.back().time)) f.refuse("time", "wants more than that of the frame before");
		frame.X_BM = readPose(f);
		m_scene.path.push_back(frame);
	}

	void readWatch(JsonFields& root)
	{
		const Json* pairs = root.list("pairs");
		m_scene.onlyPairs = pairs != nullptr;
		for (size_t i = 0; pairs && i < pairs->size() && !m_problem; ++i)
		{
			const std::string at = "pairs[" + std::to_string(i) + "]";
			const Json& pair = (*pairs)[i];
			if (!pair.isList() || pair.size() != 2 || !pair[0].isText() || !pair[1].isText())
			{
				root.refuse(at, "wants the names of two bodies");
				return;
			}
			const size_t a = find(root, at, pair[0].text(), m_scene.bodies, "body");
			const size_t b = find(root, at, pair[1].text(), m_scene.bodies, "body");
			if (a == b) root.refuse(at, "wants two different bodies");
			m_scene.pairs.push_back({a, b});
		}
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

	/// Refuses a recording that would overwrite an input file.
	void checkRecording(JsonFields& f, const std::string& file)
	{
		if (m_problem) return;
		if (isSameFile(file, m_scene.file)) f.refuse("file", "is the scene file itself");
		for (const SceneAsset& asset : m_scene.assets)
			if (isSameFile(file, asset.mesh) || isSameFile(file, asset.ist)) f.refuse("file", "is that of the asset " + asset.name);
		for (const SceneHook& other : m_scene.hooks)
			if (isSameFile(file, other.file)) f.refuse("file", "another hook records into it already");
	}

	void readHook(JsonFields& f)
	{
		SceneHook hook;
		f.need("on");
		f.need("do");
		hook.event = static_cast<SceneHook::Event>(f.choice("on", 0, {"transform", "collision", "haptic-tick", "fault"}));
		hook.action = static_cast<SceneHook::Action>(f.choice("do", 1, {"record", "count", "force", "damping", "scale", "log", "stop"}));
		using Event = SceneHook::Event;
		using Action = SceneHook::Action;
		const Action a = hook.action;
		const bool fits = (a == Action::Record && (hook.event == Event::Transform || hook.event == Event::HapticTick)) ||
			(a == Action::Count && hook.event == Event::Collision) || (a == Action::Log && hook.event == Event::Fault) ||
			(a == Action::Stop && (hook.event == Event::Fault || hook.event == Event::Collision)) ||
			((a == Action::Force || a == Action::Damping || a == Action::Scale) && hook.event == Event::HapticTick);
		if (!fits) f.refuse("do", f.text("do") + " cannot be done on " + f.text("on"));
		if (a == Action::Record)
		{
			f.need("file");
			hook.file = fileName(f.text("file"));
			hook.place = placeOf(f, "file");
			checkRecording(f, hook.file);
		}
		if (a == Action::Force) hook.force = f.vector("force", {}, 100);
		if (a == Action::Damping)
		{
			hook.damping = f.number("damping", 0, 0, 1000);
			hook.angularDamping = f.number("angularDamping", 0, 0, 1000);
		}
		if (a == Action::Scale) hook.factor = f.number("factor", 1, 0, 100);
		m_scene.hooks.push_back(hook);
	}

	const JsonSource& m_source;
	std::string m_folder;
	std::optional<Error> m_problem;
	std::vector<SceneMaterial> m_materials;
	Scene m_scene;
};
}  // namespace

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
	return readScene(JsonSource::load(path), path, std::filesystem::path(path).parent_path().string(), settings);
}
}  // namespace scenes
