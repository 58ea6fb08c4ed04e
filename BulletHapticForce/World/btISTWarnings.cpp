// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btISTWarnings.h"

#include "BulletISTCollision/Registry/btISTShapeParts.h"

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace
{
constexpr unsigned kStepsPerLook = 64;  // bodies are looked at in the first of so many steps
constexpr double kDeepTooLong = 0.1;    // time after which an impact should be over [s]

/// Whether a shape has trees, and whether one of them is not used because of the scaling.
struct Trees
{
	bool some = false, scaled = false;
};
Trees treesOf(const btCollisionShape* shape, const btISTRegistry& registry)
{
	Trees trees;
	btISTAnyPart(shape, [&](const btCollisionShape* part) {
		if (!registry.isAttached(part)) return false;
		trees.some = true;
		trees.scaled = trees.scaled || !registry.find(part);
		return false;
	});
	return trees;
}

/// Whether the contact can move one of its bodies.
bool moves(const btISTContact& contact)
{
	const btCollisionObject &a = *contact.bodyA, &b = *contact.bodyB;
	return a.hasContactResponse() && b.hasContactResponse() && !(a.isStaticOrKinematicObject() && b.isStaticOrKinematicObject());
}

bool hasBox(const btCollisionShape& shape)
{
	// Bullet refuses bodies whose box has a longer diagonal, and an empty box of btGImpactMeshShape is turned inside out.
	constexpr double kLongest = 1e6;
	btVector3 lower, upper;
	shape.getAabb(btTransform::getIdentity(), lower, upper);
	double longest = 0;
	for (int i = 0; i < 3; ++i)
	{
		// The box of level ground is flat.
		const double side = double(upper[i]) - double(lower[i]);
		if (!(side >= 0 && side < kLongest)) return false;
		longest = std::max(longest, side);
	}
	return longest > 0;
}

bool turnsNever(const btCollisionObject& object)
{
	const btRigidBody* body = btRigidBody::upcast(&object);
	return body && !body->isStaticOrKinematicObject() && body->getInvMass() > 0 && body->getInvInertiaDiagLocal().isZero() &&
		!body->getAngularFactor().isZero();
}

bool stopsAtTouch(const btCollisionObject& object, const btISTContactStore& store)
{
	return store.predictsTouch() && object.getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK;
}

const char* adviceOfDepth(btISTStiffnessRule rule)
{
	switch (rule)
	{
	case btISTStiffnessRule::Given: return "its stiffness was set: set a larger one (btISTWorld::materials)";
	case btISTStiffnessRule::StepBound: return "its stiffness is the largest that this step allows: make shorter steps";
	default: break;
	}
	return "its stiffness grows with what presses: if it stays deep, set one (btISTWorld::materials), or make shorter steps";
}
}  // namespace

const char* btISTWarnings::nameOf(btISTWarning kind)
{
	switch (kind)
	{
	case btISTWarning::Deep: return "deep contact";
	case btISTWarning::PassedThrough: return "passed through";
	case btISTWarning::TooFast: return "too fast";
	case btISTWarning::NoBox: return "no valid box";
	case btISTWarning::NoInertia: return "no inertia";
	case btISTWarning::Scaled: return "scaled since it was attached";
	case btISTWarning::IgnoredCcd: return "ignored CCD flags";
	}
	return "";
}

const char* btISTWarnings::advice(btISTWarning kind, btISTStiffnessRule rule)
{
	switch (kind)
	{
	case btISTWarning::Deep:
	case btISTWarning::PassedThrough: return adviceOfDepth(rule);
	case btISTWarning::TooFast: return "make shorter steps (btISTWorld::setMostSubsteps)";
	case btISTWarning::NoBox: return "it touches nothing: complete the mesh of the shape, and call its updateBound";
	case btISTWarning::NoInertia: return "give the body the result of calculateLocalInertia, or set its angular factor to zero";
	case btISTWarning::Scaled: return "its contact is Bullet's now: attach a tree of the scaled shape (btISTRegistry::attachScaled)";
	case btISTWarning::IgnoredCcd:
		return "only rigid bodies in a world with our solver stop at their first touch (btISTWorld::solverRefusal): make shorter steps";
	}
	return "";
}

uint64_t btISTWarnings::count() const
{
	uint64_t sum = 0;
	for (const Record& record : m_records) sum += record.count;
	return sum;
}

void btISTWarnings::note(btISTWarning kind, const btISTContact& contact)
{
	Record& record = m_records[int(kind)];
	++record.count;
	const double share = contact.depth / contact.thickness();
	if (record.count > 1 && !(share > record.share)) return;
	record = {record.count, contact.bodyA, contact.bodyB, contact.constants.k, contact.depth, share};
	m_rules[int(kind)] = contact.constants.rule;
	m_places[int(kind)][0] = contact.bodyA->getWorldArrayIndex();
	m_places[int(kind)][1] = contact.bodyB->getWorldArrayIndex();
}

void btISTWarnings::note(btISTWarning kind, const btCollisionObject& body)
{
	Record& record = m_records[int(kind)];
	++record.count;
	record.bodyA = &body;
	m_places[int(kind)][0] = body.getWorldArrayIndex();
}

void btISTWarnings::lookAtContacts(double step)
{
	btISTContactStore& store = m_registration.store();
	for (btISTContact* contact : store.contacts())
	{
		const bool isOfThisStep = contact->stamp + 1 == store.step() || contact->stamp == store.step();
		if (!isOfThisStep || !moves(*contact)) continue;
		contact->deepFor = contact->isDeep() ? contact->deepFor + step : 0;
		if (contact->deepFor > kDeepTooLong) note(btISTWarning::Deep, *contact);
		if (contact->tank.turned) note(btISTWarning::PassedThrough, *contact);
		if (contact->touchMissed) note(btISTWarning::TooFast, *contact);
	}
}

void btISTWarnings::lookAtBodies(const btCollisionWorld& world)
{
	for (const btISTWarning kind : {btISTWarning::NoBox, btISTWarning::NoInertia, btISTWarning::Scaled, btISTWarning::IgnoredCcd})
		m_records[int(kind)] = Record();
	const btCollisionObjectArray& objects = world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i)
	{
		const btCollisionObject& object = *objects[i];
		const Trees trees = treesOf(object.getCollisionShape(), m_registration.registry());
		if (!trees.some) continue;
		if (trees.scaled) note(btISTWarning::Scaled, object);
		if (!hasBox(*object.getCollisionShape())) note(btISTWarning::NoBox, object);
		if (turnsNever(object)) note(btISTWarning::NoInertia, object);
		if (object.getCcdMotionThreshold() > 0 && !stopsAtTouch(object, m_registration.store())) note(btISTWarning::IgnoredCcd, object);
	}
}

void btISTWarnings::updateAction(btCollisionWorld* world, btScalar step)
{
	lookAtContacts(double(step));
	if (m_registration.registry().size() > 0 && m_steps++ % kStepsPerLook == 0) lookAtBodies(*world);
	if (!m_waits) write();
}

void btISTWarnings::write()
{
	for (int i = 0; i < kWarningKinds; ++i)
	{
		const Record& record = m_records[i];
		if (record.count == 0 || m_written[i]) continue;
		m_written[i] = true;
		const auto kind = btISTWarning(i);
		char line[512];
		if (record.bodyB)
			std::snprintf(line, sizeof line,
				"BulletHaptics: %s: body %d and body %d, %.3g mm deep, %.2g %% of the thinner one, k %.3g Pa/m; %s. "
				"Written once; btISTSceneReport has the counts.",
				nameOf(kind), m_places[i][0], m_places[i][1], 1e3 * record.depth, 100 * record.share, record.k, advice(kind, m_rules[i]));
		else
			std::snprintf(line, sizeof line, "BulletHaptics: %s: body %d; %s. Written once; btISTSceneReport has the counts.", nameOf(kind),
				m_places[i][0], advice(kind, m_rules[i]));
		if (m_log) m_log(line);
		else std::fprintf(stderr, "%s\n", line);
	}
}
