// SPDX-License-Identifier: Zlib
#include "tests/scenario/soak/SoakWorld.h"

#include "BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h"
#include "BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h"
#include "BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h"
#include "BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h"

#include <limits>

using namespace scenario;

namespace soak
{
namespace
{
constexpr double kHalfPit = 3;
constexpr int kSpheres = 120;

constexpr double kAbsurdSpeed = 1e6;  // [m/s], [rad/s]

bool isFinite(const btVector3& v) { return std::isfinite(double(v.x())) && std::isfinite(double(v.y())) && std::isfinite(double(v.z())); }
}  // namespace

Solids::Solids()
	: cube(ist::makeBoxMesh({0.4, 0.4, 0.4}), kSpheres),
	  ring(ist::makeTorusMesh(0.45, 0.18, 16, 10), 2 * kSpheres),
	  cone(ist::makeConeMesh(0.45, 0.9, 16), kSpheres),
	  ringTriangles(ring.mesh)
{
	for (const ist::Vec3& p : cone.mesh.vertices) coneHull.addPoint(vec(p), false);
	coneHull.recalcLocalAabb();
	coneHull.setMargin(0);
	auto leaves = std::make_shared<ist::InnerSphereTree>(*cone.tree);
	leaves->surface = {};
	cone.tree = leaves;
}

bool Actor::isFinite() const
{
	const btTransform& X = body->getWorldTransform();
	bool finite = soak::isFinite(X.getOrigin()) && soak::isFinite(body->getLinearVelocity()) && soak::isFinite(body->getAngularVelocity());
	for (int row = 0; row < 3; ++row) finite = finite && soak::isFinite(X.getBasis()[row]);
	return finite;
}

SoakWorld::SoakWorld(WorldKind kind, const Solids& solids, std::vector<TreePtr> trees)
	: m_kind(kind),
	  m_solids(solids),
	  m_trees(std::move(trees))
{
	btGImpactCollisionAlgorithm::registerAlgorithm(&m_dispatcher);
	if (kind == WorldKind::MultiBody)
	{
		auto multiBody = std::make_unique<btMultiBodyConstraintSolver>();
		m_game = std::make_unique<btMultiBodyDynamicsWorld>(&m_dispatcher, &m_broadphase, multiBody.get(), &m_configuration);
		m_solver = std::move(multiBody);
	}
	else if (kind != WorldKind::Own)
	{
		if (kind == WorldKind::Nncg) m_solver = std::make_unique<btNNCGConstraintSolver>();
		else m_solver = std::make_unique<btSequentialImpulseConstraintSolver>();
		m_game = std::make_unique<btDiscreteDynamicsWorld>(&m_dispatcher, &m_broadphase, m_solver.get(), &m_configuration);
	}
	if (m_game) m_game->setGravity(btVector3(0, btScalar(-9.81), 0));
	install();
	if (kind == WorldKind::Own)
		btGImpactCollisionAlgorithm::registerAlgorithm(static_cast<btCollisionDispatcher*>(bullet().getDispatcher()));
	if (kind == WorldKind::Own) m_ist->registration().reinstall();
	addPlanes();
}

SoakWorld::~SoakWorld()
{
	while (!m_joints.empty()) separate();
	while (!m_actors.empty()) remove(m_actors.front());
	for (auto& wall : m_walls) bullet().removeRigidBody(wall.get());
	EXPECT_TRUE(m_ist->contacts().contacts().empty());
	EXPECT_EQ(m_ist->registration().registry().size(), 0);
	EXPECT_EQ(bullet().getDispatcher()->getNumManifolds(), 0);
	m_ist.reset();
}

void SoakWorld::install()
{
	if (m_game) m_ist.emplace(*m_game);
	else m_ist.emplace();
	EXPECT_EQ(m_ist->solverRefusal(), "");
}

void SoakWorld::reinstall()
{
	if (!m_game) return;
	for (Actor& actor : m_actors)
		for (Actor::Part& part : actor.parts) part.attachment.detach();
	m_ist.reset();
	EXPECT_EQ(m_game->getConstraintSolver(), m_solver.get());
	install();
}

void SoakWorld::addPlanes()
{
	for (const btVector3& normal : {btVector3(0, 1, 0), btVector3(1, 0, 0), btVector3(-1, 0, 0), btVector3(0, 0, 1), btVector3(0, 0, -1)})
	{
		m_planes.push_back(std::make_unique<btStaticPlaneShape>(normal, btScalar(normal.y() > 0 ? 0 : -kHalfPit)));
		m_walls.push_back(std::make_unique<btRigidBody>(btScalar(0), nullptr, m_planes.back().get()));
		bullet().addRigidBody(m_walls.back().get());
	}
}

namespace
{
std::unique_ptr<btCollisionShape> shapeOf(const Solids& solids, int solid)
{
	if (solid == 0) return std::make_unique<btBoxShape>(btVector3(btScalar(0.4), btScalar(0.4), btScalar(0.4)));
	if (solid == 2) return std::make_unique<btConvexHullShape>(&solids.coneHull.getPoints()[0].x(), solids.coneHull.getNumPoints());
	auto ring = std::make_unique<btGImpactMeshShape>(solids.ringTriangles.interface());
	ring->updateBound();
	return ring;
}

std::unique_ptr<btCollisionShape> stockShape(int kind)
{
	if (kind == 0) return std::make_unique<btSphereShape>(btScalar(0.35));
	if (kind == 1) return std::make_unique<btBoxShape>(btVector3(btScalar(0.3), btScalar(0.4), btScalar(0.2)));
	if (kind == 2) return std::make_unique<btCapsuleShape>(btScalar(0.2), btScalar(0.5));
	return std::make_unique<btCylinderShape>(btVector3(btScalar(0.3), btScalar(0.25), btScalar(0.3)));
}
}  // namespace

btTransform SoakWorld::somewhere(Random& random) const
{
	const double x = between(random, -2, 2), z = between(random, -2, 2);
	return at({x, between(random, 0.8, 6), z}, randomVector(random, 2));
}

Actor& SoakWorld::add(Random& random, bool volumetric)
{
	Actor& actor = m_actors.emplace_back();
	const int kind = below(random, 4);
	const int parts = volumetric && kind == 3 ? 2 : 1;
	for (int i = 0; i < parts; ++i)
	{
		Actor::Part& part = actor.parts.emplace_back();
		part.solid = !volumetric ? -1 : kind == 3 ? 0 : kind;
		part.shape = volumetric ? shapeOf(m_solids, part.solid) : stockShape(kind);
	}
	if (parts > 1)
	{
		actor.compound = std::make_unique<btCompoundShape>();
		for (int i = 0; i < parts; ++i) actor.compound->addChildShape(at({0.8 * i - 0.4, 0, 0}), actor.parts[size_t(i)].shape.get());
	}
	const btScalar mass = btScalar(std::exp(between(random, -1.5, 1.5)));
	btVector3 inertia(0, 0, 0);
	actor.shape()->calculateLocalInertia(mass, inertia);
	actor.body = std::make_unique<btRigidBody>(mass, nullptr, actor.shape(), inertia);
	actor.body->setFriction(btScalar(between(random, 0, 1)));
	place(actor, somewhere(random));
	actor.body->setLinearVelocity(vec(randomVector(random, 3)));
	actor.body->setAngularVelocity(vec(randomVector(random, 3)));
	if (volumetric)
		for (Actor::Part& part : actor.parts) attach(part);
	bullet().addRigidBody(actor.body.get());
	return actor;
}

void SoakWorld::attach(Actor::Part& part)
{
	if (part.solid < 0 || part.attachment.isAttached()) return;
	auto attached = m_ist->attach(part.shape.get(), m_trees[size_t(part.solid)]);
	const btVector3 scaling = part.shape->getLocalScaling();
	EXPECT_EQ(bool(attached), btISTRegistry::hasScaling(*part.shape, btVector3(1, 1, 1))) << scaling.x();
	if (attached) part.attachment = std::move(attached).value();
}

void SoakWorld::remove(Actor& actor)
{
	for (size_t i = m_joints.size(); i-- > 0;)
	{
		if (&m_joints[i]->getRigidBodyA() != actor.body.get() && &m_joints[i]->getRigidBodyB() != actor.body.get()) continue;
		bullet().removeConstraint(m_joints[i].get());
		m_joints.erase(m_joints.begin() + long(i));
	}
	bullet().removeRigidBody(actor.body.get());
	m_ist->materials().remove(actor.body.get());
	m_actors.remove_if([&](const Actor& a) { return &a == &actor; });
}

void SoakWorld::join(Actor& a, Actor& b)
{
	if (&a == &b) return;
	m_joints.push_back(
		std::make_unique<btPoint2PointConstraint>(*a.body, *b.body, btVector3(0, btScalar(0.7), 0), btVector3(0, btScalar(-0.7), 0)));
	bullet().addConstraint(m_joints.back().get(), true);
}

void SoakWorld::separate()
{
	if (m_joints.empty()) return;
	bullet().removeConstraint(m_joints.back().get());
	m_joints.pop_back();
}

void SoakWorld::place(Actor& actor, const btTransform& pose)
{
	actor.body->setCenterOfMassTransform(pose);  // also updates the inertia about World axes
	actor.body->setInterpolationWorldTransform(pose);
}

bool SoakWorld::isVolumetric(const btBroadphasePair& pair)
{
	const void *a = pair.m_pProxy0->m_clientObject, *b = pair.m_pProxy1->m_clientObject;
	btDispatcher& dispatcher = *bullet().getDispatcher();
	bool volumetric = false;
	for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
	{
		const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
		const void *first = manifold->getBody0(), *second = manifold->getBody1();
		if (!(first == a && second == b) && !(first == b && second == a)) continue;
		const btISTContact* contact = m_ist->contacts().find(manifold);
		const bool isOurs = contact && contact->stamp + 1 == m_ist->contacts().step();  // otherwise it was scaled, or outside the region
		// One child of a compound can have our contact and another Bullet's.
		if (!isOurs && manifold->getNumContacts() > 0) return false;
		volumetric = volumetric || isOurs;
	}
	return volumetric;
}

void SoakWorld::spreadPoison()
{
	const auto actorOf = [&](const void* object) {
		for (Actor& actor : m_actors)
			if (static_cast<btCollisionObject*>(actor.body.get()) == object) return &actor;
		return static_cast<Actor*>(nullptr);
	};
	bool spread = true;
	const auto touch = [&](Actor* a, Actor* b) {
		if (!a || !b || a->poisoned == b->poisoned) return;
		a->poisoned = b->poisoned = spread = true;
	};
	// An absurd speed counts as a poison too, and is passed on by contact.
	for (Actor& actor : m_actors)
	{
		const double speed = std::max(double(actor.body->getLinearVelocity().length()), double(actor.body->getAngularVelocity().length()));
		actor.poisoned = actor.poisoned || (actor.isFinite() && !(speed < kAbsurdSpeed));
	}
	while (std::exchange(spread, false))
	{
		for (auto& joint : m_joints) touch(actorOf(&joint->getRigidBodyA()), actorOf(&joint->getRigidBodyB()));
		const btBroadphasePairArray& pairs = bullet().getPairCache()->getOverlappingPairArray();
		for (int i = 0; i < pairs.size(); ++i)
		{
			if (!isVolumetric(pairs[i])) touch(actorOf(pairs[i].m_pProxy0->m_clientObject), actorOf(pairs[i].m_pProxy1->m_clientObject));
		}
	}
}

/// Removes Bullet's contact points of a body, because Bullet keeps points and starting impulses that are not finite. Our contacts need no
/// such removal.
void SoakWorld::cleanStockPairs(btRigidBody& body)
{
	btBroadphasePairArray& pairs = bullet().getPairCache()->getOverlappingPairArray();
	for (int i = 0; i < pairs.size(); ++i)
	{
		const bool involved = pairs[i].m_pProxy0 == body.getBroadphaseProxy() || pairs[i].m_pProxy1 == body.getBroadphaseProxy();
		if (involved && !isVolumetric(pairs[i])) bullet().getPairCache()->cleanOverlappingPair(pairs[i], bullet().getDispatcher());
	}
}

void SoakWorld::heal(Random& random)
{
	while (!m_joints.empty()) separate();
	for (Actor& actor : m_actors)
	{
		if (!std::exchange(actor.poisoned, false)) continue;
		btRigidBody& body = *actor.body;
		place(actor, somewhere(random));
		body.setLinearVelocity(btVector3(0, 0, 0));
		body.setAngularVelocity(btVector3(0, 0, 0));
		body.setInterpolationLinearVelocity(btVector3(0, 0, 0));
		body.setInterpolationAngularVelocity(btVector3(0, 0, 0));
		body.clearForces();
		body.forceActivationState(ACTIVE_TAG);
		body.setDeactivationTime(0);
		cleanStockPairs(body);
	}
}

double SoakWorld::energy() const
{
	double sum = 0;
	for (const Actor& actor : m_actors)
	{
		const btRigidBody& body = *actor.body;
		const double mass = 1 / double(body.getInvMass());
		const btVector3 w = body.getWorldTransform().getBasis().transpose() * body.getAngularVelocity(), i = body.getLocalInertia();
		sum += mass * (9.81 * double(body.getWorldTransform().getOrigin().y()) + 0.5 * double(body.getLinearVelocity().length2()));
		sum += 0.5 * double(w.x() * w.x() * i.x() + w.y() * w.y() * i.y() + w.z() * w.z() * i.z());
	}
	return sum;
}

double SoakWorld::deepestWith(double energy, const Actor& actor)
{
	const ist::InnerSphereTree& part = *m_solids.of(actor.parts[0].solid).tree;  // all parts of a body are alike
	const double weight = 9.81 / double(actor.body->getInvMass()), size = std::cbrt(part.volume);
	double stiffness = m_ist->materials().find(actor.body.get()).stiffness;
	if (stiffness == 0) stiffness = weight / (std::max(0.001 * size, part.meanGap) * size * size);
	const double resistance = stiffness * part.volume * double(actor.parts.size()) - weight;
	return resistance > 0 ? energy / resistance : std::numeric_limits<double>::infinity();
}

void SoakWorld::step(double h)
{
	if (m_game) m_game->stepSimulation(btScalar(h), 0);
	else EXPECT_FALSE(m_ist->step(h));
}
}  // namespace soak
