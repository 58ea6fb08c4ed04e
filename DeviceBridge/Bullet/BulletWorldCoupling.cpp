// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletWorldCoupling.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "LinearMath/btMotionState.h"

#include <algorithm>
#include <cmath>

namespace devicebridge
{
namespace
{
constexpr double kReach = 0.03;        // extra distance within which bodies are near [m]
constexpr double kHandSpeed = 1;       // tool speed for which a body is known before the tool can reach it within a step [m/s]
constexpr double kLeaveAt = 1.5;       // multiple of the entry distance at which a body leaves
constexpr double kStockPeriod = 1e-3;  // period for the stiffness of a contact that has none, so that it holds a copy within a tick [s]

bool isFiniteBody(const btCollisionObject& object)
{
	const btRigidBody* body = btRigidBody::upcast(&object);
	const auto finite = [](const btVector3& v) { return isFinite(toVec3(v)); };
	return isRigid(toRigidPose(object.getWorldTransform())) &&
		(!body || (finite(body->getLinearVelocity()) && finite(body->getAngularVelocity())));
}

bool movable(const btCollisionObject* object)
{
	const btRigidBody* body = btRigidBody::upcast(object);
	return body && !body->isStaticOrKinematicObject() && body->getInvMass() > 0;
}

double distanceToBox(const ist::Vec3& p, const btVector3& low, const btVector3& high)
{
	ist::Vec3 d;
	for (int i = 0; i < 3; ++i) d[i] = std::max({double(low[i]) - p[i], 0.0, p[i] - double(high[i])});
	return norm(d);
}

ist::Pose moved(const ist::Pose& X, const ist::Vec3& shift, const ist::Vec3& turn)
{
	return {rotationMatrix(ist::quaternionFromRotationVector(turn)) * X.rotation, X.translation + shift};
}

/// The part of `response` that is along `whole`, the response of a free body, limited to it.
ist::Vec3 freely(const ist::Vec3& response, const ist::Vec3& whole)
{
	const double all = squaredNorm(whole);
	return all > 0 ? response * std::clamp(dot(response, whole) / all, 0.0, 1.0) : ist::Vec3();
}
}  // namespace

BulletWorldCoupling::BulletWorldCoupling(btDynamicsWorld& world, btISTRegistration& registration, const btISTPairRule& rule)
	: m_world(world),
	  m_registration(registration),
	  m_rule(rule)
{
	m_registration.store().sumDamping(true);  // the hands need the damping, with any solver
}

BulletWorldCoupling::~BulletWorldCoupling() = default;

void BulletWorldCoupling::add(BulletDecoupledSource& hand)
{
	hand.mirror().leaveAll();
	Hand added;
	added.source = &hand;
	added.finder = std::make_unique<BulletToolContacts>(*hand.toolTree(), hand.settings().maxPairs);
	m_hands.push_back(std::move(added));
}

void BulletWorldCoupling::remove(BulletDecoupledSource& hand)
{
	const auto found = std::find_if(m_hands.begin(), m_hands.end(), [&](const Hand& h) { return h.source == &hand; });
	if (found == m_hands.end()) return;
	m_hands.erase(found);
	hand.serveContacts();  // an open question refers to trees
	hand.mirror().clear();
}

void BulletWorldCoupling::forget(const btCollisionObject* body)
{
	for (Hand& hand : m_hands)
		for (int slot = 0; slot < kMirroredBodies; ++slot)
		{
			if (hand.bodies[slot] != body) continue;
			hand.bodies[slot] = nullptr;
			hand.source->mirror().body(slot).id = nullptr;
			hand.source->mirror().leave(slot);
		}
	m_pushed.erase(std::remove_if(m_pushed.begin(), m_pushed.end(), [&](const Pushed& p) { return p.body == body; }), m_pushed.end());
}

void BulletWorldCoupling::step(double seconds)
{
	beforeStep(seconds);
	if (m_seconds > 0) m_world.stepSimulation(btScalar(seconds), 0);
	afterStep();
}

/// Begins a step. Returns false, and begins none, unless `seconds` is positive, because forces are impulses over seconds.
bool BulletWorldCoupling::begin(double seconds)
{
	m_pushed.clear();
	m_seconds = seconds > 0 && std::isfinite(seconds) ? seconds : 0;
	return m_seconds > 0;
}

void BulletWorldCoupling::show(double seconds)
{
	if (!begin(seconds)) return;
	for (Hand& hand : m_hands)
	{
		hand.source->mirror().collect();
		hand.moving = true;
	}
	m_world.performDiscreteCollisionDetection();
	publish(m_registration.store().step());
}

void BulletWorldCoupling::beforeStep(double seconds)
{
	if (!begin(seconds)) return;
	for (Hand& hand : m_hands)
	{
		WorldMirror& mirror = hand.source->mirror();
		mirror.collect();
		hand.moving = mirror.posted().tick != hand.tick;
		hand.tick = mirror.posted().tick;
		for (int slot = 0; slot < kMirroredBodies; ++slot)
			if (hand.bodies[slot]) push(hand, slot);
	}
	for (const Pushed& pushed : m_pushed)
	{
		pushed.body->activate(true);
		pushed.body->applyCentralForce(toBullet(pushed.impulse.force / m_seconds));
		pushed.body->applyTorque(toBullet(pushed.impulse.torque / m_seconds));
	}
}

void BulletWorldCoupling::push(Hand& hand, int slot)
{
	const WorldMirror::Taken& taken = hand.source->mirror().taken(slot);
	hand.applied += taken.impulse.force;
	const double size = norm(taken.impulse.force);
	btRigidBody* body = btRigidBody::upcast(hand.bodies[slot]);
	if (!movable(body) || (size == 0 && norm(taken.impulse.torque) == 0)) return;
	auto found = std::find_if(m_pushed.begin(), m_pushed.end(), [&](const Pushed& p) { return p.body == body; });
	if (found == m_pushed.end())
		found = m_pushed.insert(m_pushed.end(), {body, {toVec3(body->getLinearVelocity()), toVec3(body->getAngularVelocity())}, {}, 0});
	found->impulse = found->impulse + taken.impulse;
	found->share += size * taken.share;
}

/// Reduces the displacement, because the impulse's velocity was not present from the beginning of the step. A body that a table or
/// neighbour holds gained little of it, and stays.
void BulletWorldCoupling::putBack()
{
	for (const Pushed& pushed : m_pushed)
	{
		btRigidBody& body = *pushed.body;
		const double size = norm(pushed.impulse.force);
		if (!(size > 0)) continue;
		const double late = std::min(1.0, pushed.share / size) * m_seconds;
		const ist::Vec3 turning = toVec3(body.getInvInertiaTensorWorld() * toBullet(pushed.impulse.torque));
		const ist::Vec3 pushing = double(body.getInvMass()) * pushed.impulse.force + m_seconds * toVec3(body.getGravity());
		const ist::Vec3 gained = freely(toVec3(body.getLinearVelocity()) - pushed.before.linear, pushing);
		const ist::Vec3 spun = freely(toVec3(body.getAngularVelocity()) - pushed.before.angular, turning);
		const btTransform pose = toTransform(moved(toPose(body.getWorldTransform()), -late * gained, -late * spun));
		body.setWorldTransform(pose);
		body.setInterpolationWorldTransform(pose);
		if (body.getMotionState()) body.getMotionState()->setWorldTransform(pose);
	}
}

void BulletWorldCoupling::afterStep()
{
	if (m_seconds > 0) publish(m_registration.store().step() - 1);
}

/// `stamp` is that of the contacts of the present world.
void BulletWorldCoupling::publish(std::uint64_t stamp)
{
	for (Hand& hand : m_hands)
	{
		WorldSnapshot& out = hand.source->mirror().writable();
		chooseBodies(hand);
		out.contactCount = 0;
		showContacts(hand, out, stamp);
		showStockContacts(hand, out);
	}
	putBack();
	for (Hand& hand : m_hands)
	{
		WorldMirror& mirror = hand.source->mirror();
		for (int slot = 0; slot < kMirroredBodies; ++slot)
			if (hand.bodies[slot] && isFiniteBody(*hand.bodies[slot])) describe(hand, slot);
		findToolContacts(hand, mirror.writable());
		mirror.publish(m_seconds);
	}
}

void BulletWorldCoupling::chooseBodies(Hand& hand)
{
	WorldMirror& mirror = hand.source->mirror();
	const ist::InnerSphereTree& tree = *hand.source->toolTree();
	const ist::Vec3 center = mirror.posted().tool.X_WT * tree.origin;
	const double radius = norm(componentMax(tree.box.upper, -tree.box.lower));
	const double reach = radius + kReach + kHandSpeed * m_seconds;
	for (int slot = 0; slot < kMirroredBodies; ++slot)
	{
		if (mirror.releaseIfDone(slot)) hand.bodies[slot] = nullptr;
		if (!hand.bodies[slot]) continue;
		btVector3 low, high;
		hand.bodies[slot]->getCollisionShape()->getAabb(hand.bodies[slot]->getWorldTransform(), low, high);
		const bool near = distanceToBox(center, low, high) <= kLeaveAt * reach;
		const bool stays = near && isAsAdmitted(hand, slot) && watches(hand, *hand.bodies[slot], true) && isFiniteBody(*hand.bodies[slot]);
		if (!stays) mirror.leave(slot);
	}
	if (!hand.moving) return;
	const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i) admit(hand, *objects[i], center, reach);
}

/// Whether a body still has contact response, and the tree with which it entered is still that of its shape. Without a tree its shape must
/// still be a plane.
bool BulletWorldCoupling::isAsAdmitted(const Hand& hand, int slot) const
{
	const btCollisionShape* shape = hand.bodies[slot]->getCollisionShape();
	const auto tree = m_registration.registry().find(shape);
	if (tree != hand.source->mirror().tree(slot) || !hand.bodies[slot]->hasContactResponse()) return false;
	return tree || shape->getShapeType() == STATIC_PLANE_PROXYTYPE;
}

/// Whether the pair filter accepts tool and body. The tool is in no world, so its box is that of its last post.
bool BulletWorldCoupling::watches(const Hand& hand, const btCollisionObject& body, bool was) const
{
	const btISTPairFilter& filter = m_registration.pairFilter();
	const btRigidBody& tool = hand.source->tool();
	if (!filter.acceptsPair(&tool, &body)) return false;
	btVector3 lowerTool, upperTool, lower, upper;
	tool.getCollisionShape()->getAabb(toTransform(hand.source->mirror().posted().tool.X_WT), lowerTool, upperTool);
	body.getCollisionShape()->getAabb(body.getWorldTransform(), lower, upper);
	return filter.acceptsBoxes(lowerTool, upperTool, lower, upper, was);
}

void BulletWorldCoupling::admit(Hand& hand, btCollisionObject& object, const ist::Vec3& center, double reach)
{
	if (!object.hasContactResponse() || !btRigidBody::upcast(&object) || !isFiniteBody(object)) return;
	if (!watches(hand, object, false)) return;
	const btCollisionShape* shape = object.getCollisionShape();
	btVector3 low, high;
	shape->getAabb(object.getWorldTransform(), low, high);
	if (distanceToBox(center, low, high) > reach || hand.source->mirror().find(&object) >= 0) return;
	auto tree = m_registration.registry().find(shape);
	if (!tree && shape->getShapeType() != STATIC_PLANE_PROXYTYPE) return;
	if (tree) hand.source->reserve(*tree);
	const int slot = hand.source->mirror().admit(&object, std::move(tree));
	if (slot < 0)
	{
		++m_crowded;
		return;
	}
	hand.bodies[slot] = &object;
}

void BulletWorldCoupling::describe(Hand& hand, int slot)
{
	MirroredBody& out = hand.source->mirror().body(slot);
	const btRigidBody& body = *btRigidBody::upcast(hand.bodies[slot]);
	out.X_WB = toRigidPose(body.getWorldTransform());
	out.X_WB.rotation = rotationMatrix(quaternion(out.X_WB.rotation));
	out.twist = {toVec3(body.getLinearVelocity()), toVec3(body.getAngularVelocity())};
	out.inverseMass = {};
	out.inverseInertia = ist::zeroMat3();
	if (movable(&body))
	{
		const ist::Mat3 R = out.X_WB.rotation;
		out.inverseMass = double(body.getInvMass()) * toVec3(body.getLinearFactor());
		ist::Pose inertia = toPose(btTransform(body.getInvInertiaTensorWorld()));
		out.inverseInertia = transpose(R) * inertia.rotation * R;
		out.gravity = toVec3(body.getGravity());
	}
	if (out.leaving) return;  // its shape may have been replaced
	if (!out.tree)
	{
		const auto* plane = static_cast<const btStaticPlaneShape*>(body.getCollisionShape());
		out.planeNormal = normalized(out.X_WB.rotation * toVec3(plane->getPlaneNormal()));
		out.planeOffset = double(plane->getPlaneConstant()) + dot(out.planeNormal, out.X_WB.translation);
	}
	btRigidBody& tool = hand.source->tool();
	btISTContact pair;
	pair.treeA = hand.source->toolTree();
	pair.treeB = hand.source->mirror().tree(slot);
	pair.halfSpace = !pair.treeB;
	const btISTPairConstants constants = m_rule.decide(pair, &tool, &body);
	out.k = constants.k;
	out.toolWeight = constants.weightA;
	out.dissipation = constants.dissipation;
	out.friction = std::max(0.0, double(gCalculateCombinedFrictionCallback(&tool, &body)));
}

/// Pose at the beginning of the step just taken, because all integrals of contact are about that pose.
ist::Pose BulletWorldCoupling::begunAt(const btCollisionObject* object) const
{
	const btRigidBody* body = btRigidBody::upcast(object);
	const ist::Pose X = toRigidPose(object->getWorldTransform());
	if (!movable(object) || !body->isActive()) return X;
	return moved(X, -m_seconds * toVec3(body->getLinearVelocity()), -m_seconds * toVec3(body->getAngularVelocity()));
}

void BulletWorldCoupling::showContacts(Hand& hand, WorldSnapshot& out, std::uint64_t stamp)
{
	const btISTContactStore& store = m_registration.store();
	for (const btISTContact* contact : store.contacts())
	{
		const int a = hand.source->mirror().find(contact->bodyA), b = hand.source->mirror().find(contact->bodyB);
		const bool mirrored = (a >= 0 && movable(contact->bodyA)) || (b >= 0 && movable(contact->bodyB));
		if (!mirrored || contact->patchCount == 0) continue;
		const bool asleep = !contact->bodyA->isActive() && !contact->bodyB->isActive();
		if (contact->stamp != stamp && !asleep) continue;
		const ist::Pose X_WA = a >= 0 ? begunAt(contact->bodyA) : ist::Pose(), X_WB = b >= 0 ? begunAt(contact->bodyB) : ist::Pose();
		btContactPatch patch;
		for (int i = 0; i < contact->patchCount && out.contactCount < kMirroredContacts; ++i)
		{
			if (!evaluateContactPatch(*contact, i, patch)) continue;
			LinearContact& c = out.contacts[out.contactCount++] = linearContact(patch, X_WA, X_WB);
			c.a = a;
			c.b = b;
			c.friction = std::max(0.0, double(gCalculateCombinedFrictionCallback(contact->bodyA, contact->bodyB)));
		}
	}
}

/// Shows Bullet's own points with their impulses. They have no stiffness, so they get one that holds within a tick.
void BulletWorldCoupling::showStockContacts(Hand& hand, WorldSnapshot& out)
{
	btDispatcher& dispatcher = *m_world.getDispatcher();
	for (int m = 0; m < dispatcher.getNumManifolds(); ++m)
	{
		const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
		const int a = hand.source->mirror().find(manifold.getBody0()), b = hand.source->mirror().find(manifold.getBody1());
		const bool movableA = a >= 0 && movable(manifold.getBody0()), movableB = b >= 0 && movable(manifold.getBody1());
		if ((!movableA && !movableB) || m_registration.store().find(&manifold)) continue;
		const double inverse = (movableA ? double(btRigidBody::upcast(manifold.getBody0())->getInvMass()) : 0) +
			(movableB ? double(btRigidBody::upcast(manifold.getBody1())->getInvMass()) : 0);
		const ist::Pose X_WA = a >= 0 ? toRigidPose(manifold.getBody0()->getWorldTransform()) : ist::Pose();
		const ist::Pose X_WB = b >= 0 ? toRigidPose(manifold.getBody1()->getWorldTransform()) : ist::Pose();
		for (int i = 0; i < manifold.getNumContacts() && out.contactCount < kMirroredContacts; ++i)
		{
			const btManifoldPoint& point = manifold.getContactPoint(i);
			LinearContact& c = out.contacts[out.contactCount++] = {};
			c.a = a;
			c.b = b;
			c.X_WA = X_WA;
			c.X_WB = X_WB;
			c.point = toVec3(point.getPositionWorldOnB());
			c.normal = toVec3(point.m_normalWorldOnB);
			const double k = 1 / (inverse * kStockPeriod * kStockPeriod * manifold.getNumContacts());
			// A point without an impulse carries as soon as its gap has closed.
			const double carried = double(point.m_appliedImpulse) / m_seconds, gap = std::max(0.0, double(point.getDistance()));
			c.wrench.force = c.normal * (carried > 0 ? carried : -k * gap);
			for (int row = 0; row < 3; ++row)
				for (int column = row; column < 3; ++column) c.stiffness(row, column) = k * c.normal[row] * c.normal[column];
			c.friction = std::max(0.0, double(point.m_combinedFriction));
		}
	}
}

void BulletWorldCoupling::findToolContacts(Hand& hand, WorldSnapshot& out)
{
	out.toolContactCount = 0;
	if (hand.source->topology() != ContactThreading::InWorldThread) return;
	WorldMirror& mirror = hand.source->mirror();
	double volume = 0;
	for (int slot = 0; slot < kMirroredBodies; ++slot)
	{
		const MirroredBody& body = mirror.body(slot);
		if (!hand.bodies[slot] || body.leaving) continue;
		out.toolContactCount += hand.finder->find(mirror.posted().tool.X_WT, body, body.X_WB, slot, out.toolContacts + out.toolContactCount,
			kToolContacts - out.toolContactCount, volume);
	}
}

ist::Vec3 BulletWorldCoupling::appliedImpulse(const BulletDecoupledSource& hand) const
{
	for (const Hand& h : m_hands)
		if (h.source == &hand) return h.applied;
	return {};
}
}  // namespace devicebridge
