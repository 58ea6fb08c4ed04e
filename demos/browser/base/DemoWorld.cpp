// SPDX-License-Identifier: Zlib
#include "demos/browser/base/DemoWorld.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h"
#include "LinearMath/btIDebugDraw.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

using namespace ist;

namespace browser
{
struct DemoWorld::Stock
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

namespace
{
class LineCollector : public btIDebugDraw
{
public:
	explicit LineCollector(DrawList& list) : m_list(list) {}
	void drawLine(const btVector3& from, const btVector3& to, const btVector3& colour) override
	{
		// Bullet draws planes as lines of 1e6 m, which are left out.
		if (from.length2() > btScalar(1e8) || to.length2() > btScalar(1e8) || from == to) return;
		m_list.lines.push_back({toVec3(from), toVec3(to), {0.8f * float(colour.x()), 0.8f * float(colour.y()), 0.8f * float(colour.z())}});
	}
	void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override {}
	void reportErrorWarning(const char*) override {}
	void draw3dText(const btVector3&, const char*) override {}
	void setDebugMode(int mode) override { m_mode = mode; }
	int getDebugMode() const override { return m_mode; }

private:
	DrawList& m_list;
	int m_mode = 0;
};
/// Error of the pressure force of one contact [N].
double forceError(const btISTContact& contact, const btISTContactCache& contactCache)
{
	const btISTPairConstants& c = contact.constants;
	const double force = std::max(
		norm(pressureWrench(contact.total, {c.k, c.weightA, c.weightB}).force), btISTCachedResult::floorForce(contact));
	const double asked = contact.accuracy.level >= 0 ? contact.accuracy.errorBound * force : contact.error.force;
	return std::hypot(asked, contact.use == btISTCachedResult::Moved ? contactCache.maxError * force : 0);
}
}  // namespace

Pose DemoWorld::Body::X_WP() const { return toPose(body->getWorldTransform()); }

DemoWorld::DemoWorld(scenes::Response response, const Vec3& gravity)
{
	if (response == scenes::Response::Stock)
	{
		m_stock = std::make_unique<Stock>();
		btGImpactCollisionAlgorithm::registerAlgorithm(&m_stock->dispatcher);
		m_stock->world.setGravity(toBullet(gravity));
		return;
	}
	m_volumetric = std::make_unique<btISTWorld>();
	m_error = m_volumetric->setGravity(toBullet(gravity));
	m_volumetric->contacts().measureQueryTime(true);
}

DemoWorld::~DemoWorld()
{
	for (auto& constraint : m_constraints) bullet().removeConstraint(constraint.get());
	for (Body& b : m_bodies) bullet().removeRigidBody(b.body.get());
	for (auto& plane : m_planes) bullet().removeRigidBody(plane.get());
}

btDiscreteDynamicsWorld& DemoWorld::bullet() { return m_stock ? m_stock->world : m_volumetric->bullet(); }

btRigidBody* DemoWorld::addPlane(const Vec3& normal, double offset, double friction, const btContactMaterial& material)
{
	m_planeShapes.push_back(std::make_unique<btStaticPlaneShape>(toBullet(normal), btScalar(offset)));
	m_planes.push_back(std::make_unique<btRigidBody>(btScalar(0), nullptr, m_planeShapes.back().get()));
	btRigidBody* plane = m_planes.back().get();
	plane->setFriction(btScalar(friction));
	if (m_volumetric)
		if (auto refused = m_volumetric->materials().set(plane, material)) m_error = refused;
	bullet().addRigidBody(plane);
	return plane;
}

btRigidBody* DemoWorld::enter(Body&& made, const BodySetup& setup, double mass, const btVector3& inertia, const Pose& X_WP)
{
	made.name = setup.name;
	made.colour = setup.colour;
	made.body = std::make_unique<btRigidBody>(
		btScalar(setup.fixed ? 0 : mass), nullptr, made.shape.get(), setup.fixed ? btVector3(0, 0, 0) : inertia);
	btRigidBody* body = made.body.get();
	body->setWorldTransform(toTransform(X_WP));
	body->setInterpolationWorldTransform(toTransform(X_WP));
	body->setFriction(btScalar(setup.friction));
	if (m_volumetric)
	{
		if (made.solid)
		{
			Result<btISTAttachment> attached = m_volumetric->attach(made.shape.get(), made.solid->tree);
			if (!attached) return m_error = attached.error(), nullptr;
			made.attachment = std::move(attached).value();
		}
		if (auto refused = m_volumetric->materials().set(body, {setup.stiffness, setup.dissipation})) return m_error = refused, nullptr;
	}
	bullet().addRigidBody(body);
	m_bodies.push_back(std::move(made));
	return body;
}

btRigidBody* DemoWorld::add(const SolidPtr& solid, BodySetup setup)
{
	Body made;
	made.solid = solid;
	made.surface = solid->surface;
	made.shape = std::move(setup.shape);
	if (!made.shape)
	{
		StockShape own = m_stock ? makeStockShape(solid->mesh, setup.fixed) : StockShape{nullptr, makeHull(solid->mesh)};
		made.triangles = std::move(own.triangles);
		made.shape = std::move(own.shape);
	}
	const double mass = setup.mass > 0 ? setup.mass : setup.density * solid->tree->volume;
	btVector3 inertia;
	for (int i = 0; i < 3; ++i) inertia[i] = btScalar(mass / solid->tree->volume * solid->tree->inertia.m[i][i]);
	return enter(std::move(made), setup, mass, inertia, setup.X_WM * solid->X_MP);
}

btRigidBody* DemoWorld::addShape(std::unique_ptr<btCollisionShape> shape, Mesh mesh, BodySetup setup)
{
	Body made;
	made.surface = makeSurfaceModel(mesh);
	const double mass = setup.mass > 0 ? setup.mass : setup.density * massProperties(mesh).volume;
	made.mesh = std::move(mesh);
	made.shape = std::move(shape);
	btVector3 inertia(0, 0, 0);
	if (!setup.fixed) made.shape->calculateLocalInertia(btScalar(mass), inertia);
	return enter(std::move(made), setup, mass, inertia, setup.X_WM);
}

void DemoWorld::remove(const btRigidBody* body)
{
	const auto found = std::find_if(m_bodies.begin(), m_bodies.end(), [&](const Body& b) { return b.body.get() == body; });
	if (found == m_bodies.end()) return;
	bullet().removeRigidBody(found->body.get());
	if (m_volumetric) m_volumetric->materials().remove(body);
	m_bodies.erase(found);
}

void DemoWorld::addConstraint(std::unique_ptr<btTypedConstraint> constraint)
{
	bullet().addConstraint(constraint.get());
	m_constraints.push_back(std::move(constraint));
}

void DemoWorld::step(double h)
{
	if (m_volumetric) m_volumetric->contacts().resetQueryTime();
	const auto start = std::chrono::steady_clock::now();
	if (m_volumetric) m_volumetric->step(h);
	else m_stock->world.stepSimulation(btScalar(h), 0);
	m_stepMicroseconds = 1e6 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	m_lastStep = h;
}

ContactSums DemoWorld::contactSums() const
{
	ContactSums sums;
	if (!(m_lastStep > 0)) return sums;
	for (const StockContact& contact : stockContacts()) sums.force += norm(contact.impulse) / m_lastStep;
	if (!m_volumetric) return sums;
	for (const btISTContact* contact : m_volumetric->contacts().contacts())
	{
		if (contact->patchCount == 0) continue;
		Vec3 impulse;
		for (int i = 0; i < contact->patchCount; ++i) impulse += contact->impulses[i].force;
		sums.force += norm(impulse) / m_lastStep;
		sums.forceError = std::hypot(sums.forceError, forceError(*contact, m_volumetric->registration().contactCache()));
		sums.volume += contact->total.volume;
		sums.pairs += contact->total.pairs;
		sums.patches += contact->patchCount;
	}
	sums.queryMicroseconds = 1e6 * m_volumetric->contacts().querySeconds();
	return sums;
}

std::vector<StockContact> DemoWorld::stockContacts() const
{
	std::vector<StockContact> all;
	if (!m_stock) return all;
	for (int i = 0; i < m_stock->dispatcher.getNumManifolds(); ++i)
	{
		const btPersistentManifold& manifold = *m_stock->dispatcher.getManifoldByIndexInternal(i);
		StockContact contact{manifold.getBody0(), manifold.getBody1(), {}, {}, {}};
		for (int k = 0; k < manifold.getNumContacts(); ++k)
		{
			const btManifoldPoint& p = manifold.getContactPoint(k);
			if (!(p.getAppliedImpulse() > 0)) continue;
			contact.points.push_back(toVec3(p.getPositionWorldOnB()));
			contact.center += contact.points.back();
			contact.impulse += toVec3(p.getAppliedImpulse() * p.m_normalWorldOnB + p.m_appliedImpulseLateral1 * p.m_lateralFrictionDir1 +
				p.m_appliedImpulseLateral2 * p.m_lateralFrictionDir2);
		}
		if (contact.points.empty()) continue;
		contact.center = contact.center / double(contact.points.size());
		all.push_back(std::move(contact));
	}
	return all;
}

Vec3 DemoWorld::contactForce(const btCollisionObject* body, const btCollisionObject* other) const
{
	Vec3 sum;
	if (!(m_lastStep > 0)) return sum;
	const auto touches = [&](const btCollisionObject* a, const btCollisionObject* b) {
		return (a == body && (!other || b == other)) || (b == body && (!other || a == other));
	};
	for (const StockContact& contact : stockContacts())
		if (touches(contact.bodyA, contact.bodyB)) sum += (contact.bodyA == body ? 1 : -1) / m_lastStep * contact.impulse;
	if (!m_volumetric) return sum;
	for (const btISTContact* contact : m_volumetric->contacts().contacts())
	{
		if (!touches(contact->bodyA, contact->bodyB)) continue;
		for (int i = 0; i < contact->patchCount; ++i) sum += (contact->bodyA == body ? 1 : -1) / m_lastStep * contact->impulses[i].force;
	}
	return sum;
}

double DemoWorld::mechanicalEnergy() const
{
	double energy = 0;
	for (const Body& b : m_bodies)
	{
		if (b.body->isStaticOrKinematicObject()) continue;
		const double mass = 1 / double(b.body->getInvMass());
		const Vec3 v = toVec3(b.body->getLinearVelocity());
		const btVector3 w = b.body->getAngularVelocity();
		const btMatrix3x3 inertia = b.body->getInvInertiaTensorWorld().inverse();
		energy += 0.5 * mass * dot(v, v) + 0.5 * double(w.dot(inertia * w)) -
			mass * dot(toVec3(b.body->getGravity()), b.X_WP().translation);
	}
	return energy;
}

void DemoWorld::keepAwake(bool on)
{
	for (Body& b : m_bodies)
		if (!b.body->isStaticOrKinematicObject())
		{
			b.body->forceActivationState(on ? DISABLE_DEACTIVATION : ACTIVE_TAG);
			b.body->setDeactivationTime(0);
		}
}

void DemoWorld::debugLines(const DrawChoice& choice, DrawList& list)
{
	LineCollector collector(list);
	if (m_volumetric && (choice.patches || choice.pairs))
	{
		btISTDebugDraw what;
		what.patches = what.stock = choice.patches;
		what.pairs = choice.pairs;
		// Arrows and texts of forces are those of ContactView: they include friction.
		what.text = false;
		what.metresPerNewton = 0;
		collector.setDebugMode(btIDebugDraw::DBG_DrawContactPoints);
		m_volumetric->debugDraw(collector, what);
	}
	if (!choice.boxes && !choice.constraints) return;
	int mode = 0;
	if (choice.boxes) mode |= btIDebugDraw::DBG_DrawAabb;
	if (choice.constraints) mode |= btIDebugDraw::DBG_DrawConstraints | btIDebugDraw::DBG_DrawConstraintLimits;
	collector.setDebugMode(mode);
	bullet().setDebugDrawer(&collector);
	bullet().debugDrawWorld();
	bullet().setDebugDrawer(nullptr);
}
}  // namespace browser
