// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/SceneWorld.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "TestSupport/SceneFiles/AssetCache.h"
#include "TestSupport/SceneFiles/PrincipalMesh.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

#include <cmath>
#include <optional>
#include <utility>

using namespace ist;

namespace scenes
{
namespace
{
struct Asset
{
	std::shared_ptr<const InnerSphereTree> tree;
	PrincipalMesh principal;
	std::vector<Vec3> hull;
};

std::vector<Vec3> cornersOf(const InnerSphereTree& tree)
{
	std::vector<Vec3> corners;
	for (int i = 0; i < 8; ++i)
		corners.push_back(tree.origin +
			Vec3{i & 1 ? tree.box.upper.x : tree.box.lower.x, i & 2 ? tree.box.upper.y : tree.box.lower.y,
				i & 4 ? tree.box.upper.z : tree.box.lower.z});
	return corners;
}

/// True when the tree is in the frame that Bullet needs: the centre of mass at the origin, and principal axes.
bool isPrincipal(const InnerSphereTree& tree)
{
	const double size = tree.box.longestSide(), least = 1e-4 * size;
	const Mat3& I = tree.inertia;
	const double trace = I.m[0][0] + I.m[1][1] + I.m[2][2];
	const double off = std::fabs(I.m[0][1]) + std::fabs(I.m[0][2]) + std::fabs(I.m[1][2]);
	return norm(tree.origin) <= least && off <= 1e-3 * trace;
}

Result<Mesh> sourceMesh(const SceneAsset& asset, const SceneBuildOptions& options)
{
	if (asset.mesh.empty()) return asset.shape;
	Result<Mesh> read = importMesh(asset.mesh, asset.unit > 0 ? std::optional(asset.unit) : std::nullopt, options.progress);
	if (!read) return read.error();
	Mesh mesh = std::move(read).value();
	const double scale = asset.unit <= 0 && asset.longestSide > 0 ? asset.longestSide / bounds(mesh).longestSide() : 1;
	for (Vec3& p : mesh.vertices) p *= scale;
	const Result<RepairedMesh> repaired = repair(mesh, RepairMode::Auto, options.progress);
	if (!repaired) return repaired.error();
	if (options.say)
		for (const std::string& sentence : mesh.notTaken) options.say(asset.name + ": " + sentence);
	if (options.say)
		for (const std::string& action : repaired.value().actions) options.say(asset.name + ": " + action);
	return repaired.value().mesh;
}

Error at(const std::string& place, const Error& error) { return {place + ": " + error.message, error.cancelled}; }

Result<std::vector<Asset>> makeAssets(const Scene& scene, const SceneBuildOptions& options)
{
	std::vector<Asset> assets;
	for (const SceneAsset& from : scene.assets)
	{
		Asset asset;
		if (!from.ist.empty())
		{
			Result<InnerSphereTree> loaded = loadAsset(from.ist);
			if (!loaded) return at(from.place, loaded.error());
			asset.tree = std::make_shared<const InnerSphereTree>(std::move(loaded).value());
			asset.hull = cornersOf(*asset.tree);
		}
		else
		{
			const Result<Mesh> mesh = sourceMesh(from, options);
			if (!mesh) return at(from.place, mesh.error());
			asset.principal = inPrincipalFrame(mesh.value());
			BuildOptions build;
			build.maxSpheres = from.spheres;
			build.seed = from.seed;
			build.progress = options.progress;
			const Result<CachedTree> built = treeFromCache(asset.principal.mesh, build, options.cache, from.name, options.say);
			if (!built) return at(from.place, built.error());
			asset.tree = built.value().tree;
			asset.hull = asset.principal.mesh.vertices;
		}
		if (scene.maxPairs >= 0 && !hasLevels(*asset.tree))  // a pair budget needs coarser levels
		{
			auto levelled = std::make_shared<InnerSphereTree>(*asset.tree);
			addLevels(*levelled);
			asset.tree = std::move(levelled);
		}
		assets.push_back(std::move(asset));
	}
	return assets;
}

/// Makes a body that is not yet in a world.
Result<SceneWorld::Body> makeBody(const SceneBody& from, const std::vector<Asset>& assets, const Vec3& gravity)
{
	SceneWorld::Body body;
	body.name = from.name;
	double mass = from.mass;
	btVector3 inertia(0, 0, 0);
	if (from.kind == SceneBody::Kind::Asset)
	{
		const Asset& asset = assets[from.asset];
		if (!from.fixed && asset.principal.mesh.vertices.empty() && !isPrincipal(*asset.tree))
			return Error{from.place +
				": the asset of a body that moves has its centre of mass at the origin and its principal axes along x, y, z; "
				"name its mesh instead, which is turned so"};
		body.tree = asset.tree;
		body.mesh = asset.principal.mesh;
		body.X_MP = asset.principal.X_MP;
		auto hull = std::make_unique<btConvexHullShape>();
		for (const Vec3& p : asset.hull) hull->addPoint(toBullet(p), false);
		hull->setMargin(btScalar(1e-3));
		hull->recalcLocalAabb();
		body.shape = std::move(hull);
		if (!(mass > 0)) mass = from.material.density * body.tree->volume;
		for (int i = 0; i < 3; ++i) inertia[i] = btScalar(mass / body.tree->volume * body.tree->inertia.m[i][i]);
	}
	else if (from.kind == SceneBody::Kind::Plane)
		body.shape = std::make_unique<btStaticPlaneShape>(toBullet(from.normal), btScalar(from.offset));
	else
	{
		const Vec3& h = from.halfExtents;
		const bool box = from.kind == SceneBody::Kind::Box;
		if (box) body.shape = std::make_unique<btBoxShape>(toBullet(h));
		else body.shape = std::make_unique<btSphereShape>(btScalar(from.radius));
		if (!(mass > 0))
			mass = from.material.density * (box ? 8 * h.x * h.y * h.z : 4 / 3.0 * 3.14159265358979323846 * std::pow(from.radius, 3));
		if (!from.fixed) body.shape->calculateLocalInertia(btScalar(mass), inertia);
	}
	if (from.fixed) mass = 0, inertia.setZero();
	body.body = std::make_unique<btRigidBody>(btScalar(mass), nullptr, body.shape.get(), inertia);
	const btTransform pose = toTransform(from.X_BM * body.X_MP);
	body.body->setWorldTransform(pose);
	body.body->setInterpolationWorldTransform(pose);
	body.body->setFriction(btScalar(from.material.friction));
	body.body->setRollingFriction(btScalar(from.material.rollingFriction));
	body.body->setSpinningFriction(btScalar(from.material.spinningFriction));
	body.body->setGravity(toBullet(gravity));
	return body;
}

std::optional<Error> filterPairs(btISTWorld& world, const Scene& scene, const std::vector<SceneWorld::Body>& bodies)
{
	btISTPairFilter& filter = world.pairFilter();
	for (const auto& [a, b] : scene.pairs) filter.addPair(bodies[a].body.get(), bodies[b].body.get());
	if (scene.onlyPairs && scene.pairs.empty())
	{
		// An empty list means that no pair is volumetric.
		filter.addPair(bodies[0].body.get(), bodies[0].body.get());
		filter.removePair(bodies[0].body.get(), bodies[0].body.get());
	}
	if (!scene.region) return std::nullopt;
	return filter.setRegion(toBullet(scene.region->lower), toBullet(scene.region->upper));
}
}  // namespace

SceneWorld::~SceneWorld()
{
	for (Body& body : m_bodies)
		if (body.body->isInWorld()) m_world.bullet().removeRigidBody(body.body.get());
}

const char* SceneWorld::nameOf(const void* object) const
{
	for (const Body& body : m_bodies)
		if (body.body.get() == object) return body.name.c_str();
	return "world";
}

Result<std::vector<SceneWorld::Body>> SceneWorld::addTo(
	btISTWorld& world, const Scene& scene, bool withTools, const SceneBuildOptions& options)
{
	const Result<std::vector<Asset>> assets = makeAssets(scene, options);
	if (!assets) return assets.error();
	std::vector<Body> bodies;
	for (const SceneBody& from : scene.bodies)
	{
		Result<Body> body = makeBody(from, assets.value(), scene.gravity);
		if (!body) return body.error();
		bodies.push_back(std::move(body).value());
	}
	const auto inWorld = [&](size_t i) { return withTools || !scene.isTool(i); };
	if (auto refused = world.setGravity(toBullet(scene.gravity))) return *refused;
	for (size_t i = 0; i < bodies.size(); ++i)
	{
		const SceneBody& from = scene.bodies[i];
		if (auto refused = world.materials().set(bodies[i].body.get(), {from.material.stiffness, from.material.dissipation}))
			return at(from.place, *refused);
		if (!bodies[i].tree || !inWorld(i)) continue;
		Result<btISTAttachment> attached = world.attach(bodies[i].shape.get(), bodies[i].tree);
		if (!attached) return at(from.place, attached.error());
		bodies[i].attachment = std::move(attached).value();
	}
	if (auto refused = filterPairs(world, scene, bodies)) return *refused;
	for (size_t i = 0; i < bodies.size(); ++i)
		if (inWorld(i)) world.bullet().addRigidBody(bodies[i].body.get());
	return bodies;
}

Result<std::unique_ptr<SceneWorld>> SceneWorld::make(const Scene& scene, bool withTools, const SceneBuildOptions& options)
{
	std::unique_ptr<SceneWorld> made(new SceneWorld);
	Result<std::vector<Body>> bodies = addTo(made->m_world, scene, withTools, options);
	if (!bodies) return bodies.error();
	made->m_bodies = std::move(bodies).value();
	return made;
}
}  // namespace scenes
