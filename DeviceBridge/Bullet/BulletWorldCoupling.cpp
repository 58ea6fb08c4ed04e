// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletWorldCoupling.h"

#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Bullet/BulletLinks.h"
#include "DeviceBridge/Bullet/BulletShapeParts.h"

#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"
#include "LinearMath/btMotionState.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

namespace devicebridge
{
namespace
{
constexpr double kLeastNet = 0.1;   // smallest sum of the pushes on a link from which its response is learnt, over the sum of their lengths
constexpr double kLeastPush = 0.5;  // smallest change of velocity by the pushes from which it is learnt, over the change that was seen
constexpr double kStockPeriod = 1e-3;  // period for the stiffness of a contact that has none, so that it holds a copy within a tick [s]

bool movable(const btCollisionObject* object)
{
	const btRigidBody* body = btRigidBody::upcast(object);
	return body && !body->isStaticOrKinematicObject() && body->getInvMass() > 0;
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
	  m_rule(rule),
	  m_links(std::make_unique<BulletLinks>())
{
	m_registration.store().sumDamping(true);  // the hands need the damping, with any solver
}

BulletWorldCoupling::~BulletWorldCoupling() = default;

void BulletWorldCoupling::add(BulletDecoupledSource& hand)
{
	const auto isIt = [&](const Hand& h) { return h.source == &hand; };
	if (std::any_of(m_hands.begin(), m_hands.end(), isIt)) return;
	hand.mirror().leaveAll();
	Hand added;
	added.source = &hand;
	added.finder = std::make_unique<BulletToolContacts>(hand.toolParts(), hand.settings().maxPairs);
	added.tenants.resize(std::size_t(hand.mirror().slots()));
	m_hands.push_back(std::move(added));
}

void BulletWorldCoupling::remove(BulletDecoupledSource& hand)
{
	const auto found = std::find_if(m_hands.begin(), m_hands.end(), [&](const Hand& h) { return h.source == &hand; });
	if (found == m_hands.end()) return;
	m_hands.erase(found);
	m_unfelt.erase(
		std::remove_if(m_unfelt.begin(), m_unfelt.end(), [&](const BulletUnfeltBody& u) { return u.hand == &hand; }), m_unfelt.end());
	hand.serveContacts();  // an open question refers to trees
	hand.mirror().clear();
}

void BulletWorldCoupling::forget(const btCollisionObject* body)
{
	for (Hand& hand : m_hands)
		for (int slot = 0; slot < hand.source->mirror().slots(); ++slot)
		{
			btCollisionObject*& object = hand.tenants[std::size_t(slot)].object;
			if (object != body) continue;
			object = nullptr;
			hand.source->mirror().body(slot).id = nullptr;
			hand.source->mirror().leave(slot);
		}
	m_unfelt.erase(
		std::remove_if(m_unfelt.begin(), m_unfelt.end(), [&](const BulletUnfeltBody& u) { return u.body == body; }), m_unfelt.end());
	m_pushed.erase(std::remove_if(m_pushed.begin(), m_pushed.end(), [&](const Pushed& p) { return p.body == body; }), m_pushed.end());
	m_pushedLinks.erase(std::remove_if(m_pushedLinks.begin(), m_pushedLinks.end(), [&](const PushedLink& p) { return p.link == body; }),
		m_pushedLinks.end());
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
	m_pushedLinks.clear();
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
	m_sinceContacts = 0;
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
		for (int slot = 0; slot < mirror.slots(); ++slot)
			if (hand.tenants[std::size_t(slot)].object) push(hand, slot);
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
	btCollisionObject* object = hand.tenants[std::size_t(slot)].object;
	if (size == 0 && norm(taken.impulse.torque) == 0) return;
	if (const auto* link = btMultiBodyLinkCollider::upcast(object)) return pushLink(*link, taken.impulse);
	btRigidBody* body = btRigidBody::upcast(object);
	if (!movable(body)) return;
	auto found = std::find_if(m_pushed.begin(), m_pushed.end(), [&](const Pushed& p) { return p.body == body; });
	if (found == m_pushed.end())
		found = m_pushed.insert(m_pushed.end(), {body, {toVec3(body->getLinearVelocity()), toVec3(body->getAngularVelocity())}, {}, 0});
	found->impulse = found->impulse + taken.impulse;
	found->share += size * taken.share;
}

void BulletWorldCoupling::pushLink(const btMultiBodyLinkCollider& link, const ist::Wrench& impulse)
{
	if (link.isStaticOrKinematicObject()) return;
	BulletLinks::push(link, {impulse.force / m_seconds, impulse.torque / m_seconds});
	auto found = std::find_if(m_pushedLinks.begin(), m_pushedLinks.end(), [&](const PushedLink& p) { return p.link == &link; });
	if (found == m_pushedLinks.end())
	{
		MirroredBody now;
		now.X_WB = toRigidPose(link.getWorldTransform());
		m_links->describe(link, now);
		PushedLink pushed{&link, {}, 0, now.twist.linear, now.inverseMass, {}};
		// Gravity acts along the axes that the joints leave free.
		const ist::Vec3 gravity = toVec3(m_world.getGravity());
		const double mass = BulletLinks::massOf(link);
		for (int i = 0; i < 3; ++i) pushed.fall[i] = std::min(1.0, mass * now.inverseMass[i]) * m_seconds * gravity[i];
		found = m_pushedLinks.insert(m_pushedLinks.end(), pushed);
	}
	found->impulse += impulse.force;
	found->pushed += norm(impulse.force);
}

/// The share of its bound by which a link responded to the pushes of the hands. Returns `before` if the pushes cancel, or if other causes
/// changed the velocity more than the pushes can.
double BulletWorldCoupling::responseOf(const PushedLink& pushed, const ist::Vec3& velocity, double before) const
{
	ist::Vec3 expected;
	for (int i = 0; i < 3; ++i) expected[i] = pushed.inverseMass[i] * pushed.impulse[i];
	const ist::Vec3 change = velocity - pushed.before - pushed.fall;
	const double along = dot(expected, pushed.impulse);
	if (!(along > 0) || norm(pushed.impulse) < kLeastNet * pushed.pushed || norm(expected) < kLeastPush * norm(change)) return before;
	return std::clamp(dot(change, pushed.impulse) / along, 0.0, 1.0);
}

void BulletWorldCoupling::describeLink(Hand& hand, int slot, const btMultiBodyLinkCollider& link)
{
	MirroredBody& out = hand.source->mirror().body(slot);
	double& response = hand.tenants[std::size_t(slot)].response;
	if (!m_stepped) return;
	m_links->describe(link, out);
	for (const PushedLink& pushed : m_pushedLinks)
		if (pushed.link == &link) response = responseOf(pushed, out.twist.linear, response);
	if (link.isStaticOrKinematicObject()) response = 0;
	out.inverseMass *= response;
	for (auto& row : out.inverseInertia.m)
		for (double& value : row) value *= response;
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
	if (!(m_seconds > 0)) return;
	m_stepped = true;
	m_sinceContacts = m_seconds;
	publish(m_registration.store().step() - 1);
}

/// `stamp` is that of the contacts of the present world.
void BulletWorldCoupling::publish(std::uint64_t stamp)
{
	m_unfelt.clear();
	for (Hand& hand : m_hands)
	{
		WorldSnapshot& out = hand.source->mirror().writable();
		chooseBodies(hand);
		out.contactCount = 0;
		showContacts(hand, out, stamp);
		showStockContacts(hand, out);
		out.droppedContacts = hand.droppedContacts;
	}
	putBack();
	for (Hand& hand : m_hands)
	{
		WorldMirror& mirror = hand.source->mirror();
		for (int slot = 0; slot < mirror.slots(); ++slot)
		{
			const btCollisionObject* object = hand.tenants[std::size_t(slot)].object;
			if (object && isFiniteBody(*object)) describe(hand, slot);
		}
		listPairs(hand, mirror.writable());
		findToolContacts(hand, mirror.writable());
		mirror.publish(m_seconds);
	}
}

void BulletWorldCoupling::describe(Hand& hand, int slot)
{
	MirroredBody& out = hand.source->mirror().body(slot);
	const btCollisionObject& object = *hand.tenants[std::size_t(slot)].object;
	out.X_WB = toRigidPose(object.getWorldTransform());
	out.X_WB.rotation = rotationMatrix(quaternion(out.X_WB.rotation));
	out.twist = {};
	out.inverseMass = {};
	out.inverseInertia = ist::zeroMat3();
	out.friction = std::max(0.0, double(gCalculateCombinedFrictionCallback(&hand.source->tool(), &object)));
	out.gravity = {};
	if (const auto* link = btMultiBodyLinkCollider::upcast(&object)) return describeLink(hand, slot, *link);
	const btRigidBody* body = btRigidBody::upcast(&object);
	if (!body) return;
	out.twist = {toVec3(body->getLinearVelocity()), toVec3(body->getAngularVelocity())};
	if (!movable(body)) return;
	const ist::Mat3 R = out.X_WB.rotation;
	out.inverseMass = double(body->getInvMass()) * toVec3(body->getLinearFactor());
	ist::Pose inertia = toPose(btTransform(body->getInvInertiaTensorWorld()));
	out.inverseInertia = transpose(R) * inertia.rotation * R;
	out.gravity = toVec3(body->getGravity());
}

/// Pose in which the contacts were found, at the beginning of the step just taken. All their integrals are about that pose.
ist::Pose BulletWorldCoupling::begunAt(const btCollisionObject* object) const
{
	const ist::Pose X = toRigidPose(object->getWorldTransform());
	ist::Twist twist;
	if (const auto* link = btMultiBodyLinkCollider::upcast(object)) twist = m_links->twistOf(*link);
	else if (const btRigidBody* body = btRigidBody::upcast(object); movable(object) && body->isActive())
		twist = {toVec3(body->getLinearVelocity()), toVec3(body->getAngularVelocity())};
	return moved(X, -m_sinceContacts * twist.linear, -m_sinceContacts * twist.angular);
}

void BulletWorldCoupling::showContacts(Hand& hand, WorldSnapshot& out, std::uint64_t stamp)
{
	const btISTContactStore& store = m_registration.store();
	const int capacity = static_cast<int>(out.contacts.size());
	for (const btISTContact* contact : store.contacts())
	{
		const int a = hand.source->mirror().find(contact->bodyA), b = hand.source->mirror().find(contact->bodyB);
		const bool mirrored = (a >= 0 && movable(contact->bodyA)) || (b >= 0 && movable(contact->bodyB));
		if (!mirrored || contact->patchCount == 0) continue;
		const bool asleep = !contact->bodyA->isActive() && !contact->bodyB->isActive();
		if (contact->stamp != stamp && !asleep) continue;
		const ist::Pose X_WA = a >= 0 ? begunAt(contact->bodyA) : ist::Pose(), X_WB = b >= 0 ? begunAt(contact->bodyB) : ist::Pose();
		btContactPatch patch;
		for (int i = 0; i < contact->patchCount; ++i)
		{
			if (!evaluateContactPatch(*contact, i, patch)) continue;
			if (out.contactCount == capacity)
			{
				++hand.droppedContacts;
				continue;
			}
			LinearContact& c = out.contacts[std::size_t(out.contactCount++)] = linearContact(patch, X_WA, X_WB);
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
	const int capacity = static_cast<int>(out.contacts.size());
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
		for (int i = 0; i < manifold.getNumContacts(); ++i)
		{
			if (out.contactCount == capacity)
			{
				++hand.droppedContacts;
				continue;
			}
			const btManifoldPoint& point = manifold.getContactPoint(i);
			LinearContact& c = out.contacts[std::size_t(out.contactCount++)] = {};
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
	for (int i = 0; i < out.pairCount; ++i)
	{
		const MirroredPair& pair = out.pairs[std::size_t(i)];
		const MirroredBody& body = mirror.body(pair.slot);
		out.toolContactCount += hand.finder->find(mirror.posted().tool.X_WT, pair, body, body.X_WB,
			out.toolContacts.data() + out.toolContactCount, static_cast<int>(out.toolContacts.size()) - out.toolContactCount, volume);
	}
	out.coarsenedQueries = hand.finder->coarsened();
	out.queriesOverBudget = hand.finder->overBudget();
	out.refusedQueries = hand.finder->refused();
	out.droppedPatches = hand.finder->dropped();
}

ist::Vec3 BulletWorldCoupling::appliedImpulse(const BulletDecoupledSource& hand) const
{
	for (const Hand& h : m_hands)
		if (h.source == &hand) return h.applied;
	return {};
}
}  // namespace devicebridge
