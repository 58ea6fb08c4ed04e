// SPDX-License-Identifier: Zlib
#include "demos/browser/base/SceneSaver.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Json/JsonValue.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "TestSupport/SceneFiles/SceneWorld.h"
#include "demos/scenes/Pages/TextFile.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

#include <cctype>
#include <filesystem>
#include <map>
#include <set>

using namespace ist;
using Json = ist::JsonValue;

namespace browser
{
namespace
{
constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr double kStill = 1e-3;  // speed below which a body counts as being at rest [m/s, rad/s]

Json listOf(const Vec3& v)
{
	Json list = Json::list();
	for (int i = 0; i < 3; ++i) list.append(v[i]);
	return list;
}

std::string fileNameOf(std::string name)
{
	for (char& c : name)
		if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '-';
	return name;
}

class SceneSaver
{
public:
	SceneSaver(DemoWorld& world, const btRigidBody* tool, const std::string& path) : m_world(world), m_tool(tool), m_path(path) {}

	Result<std::vector<std::string>> save()
	{
		if (!m_world.volumetric()) return Error{"a scene file has volumetric contact: show the side that is not stock Bullet's"};
		m_json = {{"schema", 1}, {"name", m_path.stem().string()}};
		m_json["gravity"] = listOf(toVec3(m_world.bullet().getGravity()));
		m_json["assets"] = Json::list();
		m_json["materials"] = Json::list();
		m_json["bodies"] = Json::list();
		for (const auto& plane : m_world.planes()) addPlane(*plane);
		for (const DemoWorld::Body& body : m_world.bodies())
			if (auto refused = addBody(body)) return *refused;
		addHand();
		if (m_world.constraintCount() > 0) m_leftOut.push_back("its " + std::to_string(m_world.constraintCount()) + " joints and motors");
		if (m_moving > 0)
			m_leftOut.push_back("the velocities of bodies: " + std::to_string(m_moving) + " of them moved, and begin at rest");
		return write();
	}

	/// Removes the trees that were saved, but those of an earlier scene.
	void removeAssets() const
	{
		std::error_code ignored;
		for (const std::filesystem::path& file : m_files) std::filesystem::remove(file, ignored);
	}

private:
	std::string newName(const std::string& wanted)
	{
		const std::string base = wanted.empty() ? "body" : wanted;
		std::string name = base;
		for (int i = 2; !m_names.insert(name).second; ++i) name = base + " " + std::to_string(i);
		return name;
	}

	/// Friction and contact constants of a body, which become a material of its own.
	void addMaterial(const btRigidBody& body, Json& to)
	{
		const btContactMaterial set = m_world.volumetric()->materials().find(&body);
		const std::string name = "of " + to["name"].text();
		Json material = {{"name", name}, {"friction", double(body.getFriction())}};
		if (body.getRollingFriction() > 0) material["rollingFriction"] = double(body.getRollingFriction());
		if (body.getSpinningFriction() > 0) material["spinningFriction"] = double(body.getSpinningFriction());
		if (set.stiffness > 0) material["stiffness"] = set.stiffness;
		if (set.dissipation >= 0) material["dissipation"] = set.dissipation;
		m_json["materials"].append(material);
		to["material"] = name;
	}

	void addPlane(const btRigidBody& plane)
	{
		const auto& shape = static_cast<const btStaticPlaneShape&>(*plane.getCollisionShape());
		Json json = {{"name", newName("ground")}};
		json["plane"] = {{"normal", listOf(toVec3(shape.getPlaneNormal()))}, {"offset", double(shape.getPlaneConstant())}};
		addMaterial(plane, json);
		m_json["bodies"].append(json);
	}

	std::optional<Error> addBody(const DemoWorld::Body& body)
	{
		Json json = {{"name", newName(body.name)}};
		const btRigidBody& bullet = *body.body;
		if (body.solid)
		{
			const Result<std::string> asset = assetOf(*body.solid);
			if (!asset) return asset.error();
			json["asset"] = asset.value();
		}
		else if (bullet.getCollisionShape()->getShapeType() == BOX_SHAPE_PROXYTYPE)
			json["box"] = listOf(toVec3(static_cast<const btBoxShape*>(bullet.getCollisionShape())->getHalfExtentsWithMargin()));
		else if (bullet.getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE)
			json["sphere"] = double(static_cast<const btSphereShape*>(bullet.getCollisionShape())->getRadius());
		else
		{
			m_leftOut.push_back(json["name"].text() + ", whose shape is Bullet's " + std::string(bullet.getCollisionShape()->getName()));
			return std::nullopt;
		}
		const Pose X = body.X_WP();
		json["position"] = listOf(X.translation);
		json["turn"] = listOf(kDegrees * rotationVector(quaternion(X.rotation)));
		if (bullet.getInvMass() > 0) json["mass"] = 1 / double(bullet.getInvMass());
		else json["fixed"] = true;
		addMaterial(bullet, json);
		if (double(bullet.getLinearVelocity().length()) > kStill || double(bullet.getAngularVelocity().length()) > kStill) ++m_moving;
		if (&bullet == m_tool) m_toolName = json["name"].text(), m_toolBody = json;
		m_json["bodies"].append(json);
		return std::nullopt;
	}

	/// Saves the tree of a solid, once.
	Result<std::string> assetOf(const DemoSolid& solid)
	{
		const auto known = m_assets.find(&solid);
		if (known != m_assets.end()) return known->second;
		std::string name = solid.name;
		for (int i = 2; !m_assetNames.insert(name).second; ++i) name = solid.name + " " + std::to_string(i);
		const std::string file = fileNameOf(m_path.stem().string() + "-" + name) + ".ist";
		const std::filesystem::path path = m_path.parent_path() / file;
		std::error_code ignored;
		const bool existed = std::filesystem::exists(path, ignored);
		const Result<size_t> saved = saveAsset(*solid.tree, path.string());
		if (!saved) return saved.error();
		if (!existed) m_files.push_back(path);
		m_json["assets"].append({{"name", name}, {"ist", file}});
		return m_assets[&solid] = name;
	}

	/// A simulated hand holds the tool in place.
	void addHand()
	{
		if (m_toolName.empty())
		{
			m_leftOut.push_back("a hand, which `haptic_demos --scene` needs: add `hand`, with `device`, `tool` and `path`, or save while a "
								"hand feels (--device ADDRESS --forces, F2)");
			return;
		}
		Json path = Json::list();
		for (const double time : {0.0, 3.0})
		{
			Json frame = {{"time", time}};
			frame["position"] = m_toolBody["position"];
			frame["turn"] = m_toolBody["turn"];
			path.append(frame);
		}
		m_json["hand"] = {{"device", "sim:sigma7"}, {"tool", m_toolName}};
		m_json["hand"]["path"] = path;
		m_json["hooks"] = Json::list();
		m_json["hooks"].append({{"on", "collision"}, {"do", "count"}});
	}

	Result<std::vector<std::string>> write()
	{
		const std::string text = m_json.dump(true) + "\n";
		const Result<scenes::Scene> read = scenes::parseScene(m_path.string(), text, m_path.parent_path().string());
		if (!read) return read.error();
		const auto made = scenes::SceneWorld::make(read.value(), true, {});
		if (!made) return made.error();
		if (!scenes::writeTextFile(m_path.string(), text)) return Error{m_path.string() + ": cannot be written"};
		return m_leftOut;
	}

	DemoWorld& m_world;
	const btRigidBody* m_tool;
	std::filesystem::path m_path;
	Json m_json, m_toolBody;
	std::string m_toolName;
	std::set<std::string> m_names, m_assetNames;
	std::map<const DemoSolid*, std::string> m_assets;
	std::vector<std::filesystem::path> m_files;
	std::vector<std::string> m_leftOut;
	int m_moving = 0;
};
}  // namespace

Result<std::vector<std::string>> saveScene(DemoWorld& world, const btRigidBody* tool, const std::string& path)
{
	SceneSaver saver(world, tool, path);
	Result<std::vector<std::string>> leftOut = saver.save();
	if (!leftOut) saver.removeAssets();
	return leftOut;
}
}  // namespace browser
