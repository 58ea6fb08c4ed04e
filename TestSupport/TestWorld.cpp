// SPDX-License-Identifier: Zlib
#include "TestSupport/TestWorld.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeCache.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "TestSupport/SceneFiles/SceneWorld.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace ist::test
{
namespace
{
template <class T> T orThrow(Result<T> result)
{
	if (!result) throw std::runtime_error(result.error().message);
	return std::move(result).value();
}

constexpr double kMostSteps = 1e9;

/// Visits each rigid body of the world that can move, including bodies that were not added by this class.
template <class Visit> void eachMoving(const btDiscreteDynamicsWorld& world, const Visit& visit)
{
	const btCollisionObjectArray& objects = world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i)
		if (const btRigidBody* body = btRigidBody::upcast(objects[i]); body && !body->isStaticOrKinematicObject() && body->getInvMass() > 0)
			visit(*body);
}
}  // namespace

btTransform at(double x, double y, double z) { return at(x, y, z, btVector3(0, 1, 0), 0); }

btTransform at(double x, double y, double z, const btVector3& axis, double angle)
{
	return btTransform(btQuaternion(axis, btScalar(angle)), btVector3(btScalar(x), btScalar(y), btScalar(z)));
}

double speed(const btRigidBody& body)
{
	btVector3 centre;
	btScalar radius;
	body.getCollisionShape()->getBoundingSphere(centre, radius);
	return double(body.getLinearVelocity().length()) + double(body.getAngularVelocity().length()) * double(centre.length() + radius);
}

TestWorld::~TestWorld()
{
	for (auto& body : m_bodies) m_world.bullet().removeRigidBody(body.get());
}

btRigidBody& TestWorld::addMesh(const Mesh& mesh, double mass, const btTransform& pose)
{
	BuildOptions options;
	options.maxSpheres = m_spheres;
	// The centre of mass is that of the repaired mesh, because repair may move it.
	const RepairedMesh repaired = orThrow(repair(mesh));
	const Mesh centred = translated(repaired.mesh, -massProperties(repaired.mesh).centerOfMass);
	return addTree(orThrow(cachedTree(centred, options, m_folder)).tree, mass, pose);
}

btRigidBody& TestWorld::addMeshFile(const std::string& path, double mass, const btTransform& pose, double unit)
{
	Mesh mesh = orThrow(importMesh(path));
	for (Vec3& p : mesh.vertices) p *= unit;
	return addMesh(mesh, mass, pose);
}

btRigidBody& TestWorld::addAsset(const std::string& path, double mass, const btTransform& pose)
{
	auto tree = std::make_shared<const InnerSphereTree>(orThrow(loadAsset(path)));
	if (mass > 0 && norm(tree->origin) > 1e-3 * tree->box.longestSide())
		throw std::runtime_error(path +
			": the centre of mass of the mesh is not its origin, about which Bullet's bodies turn; move the mesh and build it again");
	return addTree(std::move(tree), mass, pose);
}

btRigidBody& TestWorld::addTree(std::shared_ptr<const InnerSphereTree> tree, double mass, const btTransform& pose)
{
	const Vec3 lower = tree->origin + tree->box.lower, upper = tree->origin + tree->box.upper;
	m_shapes.push_back(std::make_unique<btBoxShape>(toBullet(componentMax(upper, -lower))));
	m_attachments.push_back(orThrow(m_world.attach(m_shapes.back().get(), tree)));
	btRigidBody& body = addShape(*m_shapes.back(), mass, pose);
	const double density = mass / tree->volume;
	if (mass > 0)
		body.setMassProps(btScalar(mass), toBullet(density * Vec3{tree->inertia.m[0][0], tree->inertia.m[1][1], tree->inertia.m[2][2]}));
	body.updateInertiaTensor();
	mark();
	return body;
}

btRigidBody& TestWorld::addShape(btCollisionShape& shape, double mass, const btTransform& pose)
{
	if (!(mass >= 0) || !std::isfinite(mass)) throw std::runtime_error("a mass must be a finite number of kilograms and not negative");
	btVector3 inertia(0, 0, 0);
	if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
	m_bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, &shape, inertia));
	btRigidBody& body = *m_bodies.back();
	body.setWorldTransform(pose);
	body.setInterpolationWorldTransform(pose);
	body.setActivationState(DISABLE_DEACTIVATION);
	m_world.bullet().addRigidBody(&body);
	mark();
	return body;
}

btRigidBody& TestWorld::addFloor(double height)
{
	m_shapes.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(height)));
	return addShape(*m_shapes.back(), 0, btTransform::getIdentity());
}

void TestWorld::addScene(const std::string& path)
{
	const scenes::Scene scene = orThrow(scenes::loadScene(path));
	for (const scenes::SceneBody& body : scene.bodies)
		if (m_named.count(body.name))
			throw std::runtime_error(body.place + ": the world has a body that is called " + body.name + " already");
	for (scenes::SceneWorld::Body& made : orThrow(scenes::SceneWorld::addTo(m_world, scene, true, {m_folder, {}, {}})))
	{
		made.body->setActivationState(DISABLE_DEACTIVATION);
		m_named[made.name] = made.body.get();
		m_shapes.push_back(std::move(made.shape));
		m_bodies.push_back(std::move(made.body));
		m_attachments.push_back(std::move(made.attachment));
	}
	mark();
}

btRigidBody& TestWorld::body(const std::string& name)
{
	const auto found = m_named.find(name);
	if (found != m_named.end()) return *found->second;
	std::string known;
	for (const auto& each : m_named) known += (known.empty() ? "; there are " : ", ") + each.first;
	throw std::runtime_error("no body is called " + name + (known.empty() ? "; there is no scene" : known));
}

void TestWorld::run(double seconds, double h)
{
	const double count = seconds / h;
	if (!(h > 0) || !std::isfinite(h) || !(seconds >= 0) || !(count < kMostSteps))
		throw std::runtime_error("a run needs a finite time that is not negative, steps of positive length, and no more than 1e9 of them");
	const long steps = std::lround(count);
	for (long i = 0; i < steps; ++i)
	{
		m_audit->beforeStep(h);
		m_world.bullet().stepSimulation(btScalar(h), 0);
		eachMoving(m_world.bullet(), [&](const btRigidBody& body) {
			if (body.isActive()) m_gravityImpulse += (h / double(body.getInvMass())) * toVec3(body.getGravity() * body.getLinearFactor());
		});
		m_audit->afterStep();
		m_log.record(h);
		m_time += h;
	}
}

void TestWorld::mark()
{
	m_log.clear();
	m_audit = std::make_unique<btEnergyAudit>(m_world.bullet(), m_world.contacts());
	m_markMomentum = momentum();
	m_gravityImpulse = Vec3();
}

double TestWorld::energyGained() const
{
	const btEnergyBalance& sum = m_audit->total();
	return sum.residual - sum.physical - sum.numerical;
}

Vec3 TestWorld::momentum() const
{
	Vec3 sum;
	eachMoving(
		m_world.bullet(), [&](const btRigidBody& body) { sum += (1 / double(body.getInvMass())) * toVec3(body.getLinearVelocity()); });
	return sum;
}

Vec3 TestWorld::momentumFromNowhere() const
{
	Vec3 fromOutside = m_gravityImpulse;
	const btCollisionObjectArray& objects = m_world.bullet().getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i)
		if (objects[i]->isStaticOrKinematicObject()) fromOutside -= m_log.impulseOn(objects[i]);
	return momentum() - m_markMomentum - fromOutside;
}

double TestWorld::fastest() const
{
	double most = 0;
	eachMoving(m_world.bullet(), [&](const btRigidBody& body) { most = larger(most, speed(body)); });
	return most;
}
}  // namespace ist::test
