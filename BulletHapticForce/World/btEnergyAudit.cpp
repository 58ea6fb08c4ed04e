// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btEnergyAudit.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/NarrowPhaseCollision/btPersistentManifold.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <cmath>

namespace
{
btRigidBody* movingBody(btCollisionObject* object)
{
	btRigidBody* body = btRigidBody::upcast(object);
	return body && !body->isStaticOrKinematicObject() && body->getInvMass() > 0 ? body : nullptr;
}

double massOf(const btRigidBody& body) { return 1 / double(body.getInvMass()); }

ist::Twist twistOf(const btRigidBody& body) { return {toVec3(body.getLinearVelocity()), toVec3(body.getAngularVelocity())}; }

/// Inertia about the centre of mass, World axes; zero about axes that cannot rotate.
ist::Mat3 inertiaOf(const btRigidBody& body)
{
	const ist::Mat3 R = toPose(body.getWorldTransform()).rotation;
	const ist::Vec3 inverse = toVec3(body.getInvInertiaDiagLocal());
	ist::Mat3 local = ist::zeroMat3();
	const double entries[3] = {inverse.x, inverse.y, inverse.z};
	for (int i = 0; i < 3; ++i) local.m[i][i] = entries[i] > 0 ? 1 / entries[i] : 0;
	return R * local * ist::transpose(R);
}

double kineticEnergy(double mass, const ist::Mat3& inertia, const ist::Twist& t)
{
	return 0.5 * mass * dot(t.linear, t.linear) + 0.5 * dot(t.angular, inertia * t.angular);
}

/// Change of the angular velocity by Bullet's gyroscopic term, as its solver adds it.
ist::Vec3 gyroscopic(const btRigidBody& body, double h)
{
	ist::Vec3 sum;
	const int flags = body.getFlags();
	if (flags & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD) sum += toVec3(body.computeGyroscopicImpulseImplicit_World(btScalar(h)));
	if (flags & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY) sum += toVec3(body.computeGyroscopicImpulseImplicit_Body(btScalar(h)));
	return sum;
}

/// Work of kinematic bodies through Bullet's own contact: the impulses on the other body, at the velocity of the kinematic one.
double kinematicWork(const btPersistentManifold& manifold)
{
	double sum = 0;
	for (int side = 0; side < 2; ++side)
	{
		const btRigidBody* rigid = btRigidBody::upcast(side == 0 ? manifold.getBody0() : manifold.getBody1());
		const btCollisionObject* other = side == 0 ? manifold.getBody1() : manifold.getBody0();
		// A sleeping body still has the impulses of the step in which it fell asleep.
		if (!rigid || !rigid->isKinematicObject() || other->isStaticOrKinematicObject() || !other->isActive()) continue;
		for (int i = 0; i < manifold.getNumContacts(); ++i)
		{
			const btManifoldPoint& p = manifold.getContactPoint(i);
			const ist::Vec3 onBody0 = double(p.m_appliedImpulse) * toVec3(p.m_normalWorldOnB) +
				double(p.m_appliedImpulseLateral1) * toVec3(p.m_lateralFrictionDir1) +
				double(p.m_appliedImpulseLateral2) * toVec3(p.m_lateralFrictionDir2);
			const btVector3& at = side == 0 ? p.getPositionWorldOnA() : p.getPositionWorldOnB();
			const ist::Vec3 v = toVec3(rigid->getVelocityInLocalPoint(at - rigid->getCenterOfMassPosition()));
			sum += (side == 0 ? -1 : 1) * dot(onBody0, v);
		}
	}
	return sum;
}

void addTo(btEnergyBalance& total, const btEnergyBalance& step)
{
	total.kinetic = step.kinetic;
	total.potential = step.potential;
	total.contact = step.contact;
	total.physical += step.physical;
	total.numerical += step.numerical;
	total.injected += step.injected;
	total.residual += step.residual;
}
}  // namespace

btEnergyAudit::Energies btEnergyAudit::energies() const
{
	Energies sum;
	for (const Body& entry : m_bodies)
	{
		const double mass = massOf(*entry.body);
		sum.kinetic += kineticEnergy(mass, inertiaOf(*entry.body), twistOf(*entry.body));
		sum.potential -= mass * dot(entry.gravity, toVec3(entry.body->getWorldTransform().getOrigin()));
	}
	return sum;
}

/// Records damping, gyroscopic term and forces, in the order of Bullet's step.
void btEnergyAudit::enterForces(Body& entry, double h)
{
	btRigidBody& body = *entry.body;
	const double mass = massOf(body);
	entry.position = toVec3(body.getWorldTransform().getOrigin());
	entry.inertia = inertiaOf(body);
	entry.before = entry.pushed = twistOf(body);
	entry.gravityWork = 0;
	const auto energy = [&](const ist::Twist& t) { return kineticEnergy(mass, entry.inertia, t); };

	ist::Twist damped = entry.before;
	damped.linear = std::pow(1 - double(body.getLinearDamping()), h) * damped.linear;
	damped.angular = std::pow(1 - double(body.getAngularDamping()), h) * damped.angular;
	m_open.physical += energy(entry.before) - energy(damped);
	entry.pushed = damped;
	if (!body.isActive()) return;

	// Bullet computes the gyroscopic term from the damped velocity, which the body does not have yet.
	const btVector3 kept = body.getAngularVelocity();
	body.setAngularVelocity(toBullet(damped.angular));
	ist::Twist turned = damped;
	turned.angular += gyroscopic(body, h);
	body.setAngularVelocity(kept);
	m_open.numerical -= energy(turned) - energy(damped);

	const ist::Vec3 factor = toVec3(body.getLinearFactor()), g = entry.gravity;
	const ist::Vec3 weight = mass * componentProduct(factor, g);
	const ist::Vec3 force = toVec3(body.getTotalForce()), torque = toVec3(body.getTotalTorque());
	entry.pushed = turned;
	entry.pushed.linear += (h / mass) * (weight + force);
	const btMatrix3x3& inverse = body.getInvInertiaTensorWorld();
	entry.pushed.angular += h * toVec3(inverse * body.getTotalTorque());
	const ist::Vec3 mean = 0.5 * (turned.linear + entry.pushed.linear);
	entry.gravityWork = h * dot(weight, mean);
	m_open.injected += h * dot(force, mean) + 0.5 * h * dot(torque, turned.angular + entry.pushed.angular);
}

/// Records what the motion of the step does to the energy: a body falls with the velocity at the end of the step, and its inertia turns
/// with it.
void btEnergyAudit::enterMotion(const Body& entry)
{
	const btRigidBody& body = *entry.body;
	const double mass = massOf(body), fallen = mass * dot(entry.gravity, toVec3(body.getWorldTransform().getOrigin()) - entry.position);
	const ist::Twist after = twistOf(body);
	m_open.numerical += fallen - entry.gravityWork;
	m_open.numerical -= kineticEnergy(mass, inertiaOf(body), after) - kineticEnergy(mass, entry.inertia, after);
}

/// Work of a kinematic body: the contact's impulses on the other body, at this body's velocity. `sign` is 1 when this body is B, -1 when
/// it is A.
double btEnergyAudit::kinematicWork(const btISTContact& contact, const btCollisionObject& body, double sign) const
{
	const btRigidBody* rigid = btRigidBody::upcast(&body);
	if (!rigid || !rigid->isKinematicObject()) return 0;
	const ist::Vec3 v = toVec3(rigid->getLinearVelocity()), w = toVec3(rigid->getAngularVelocity());
	double sum = 0;
	for (int i = 0; i < contact.patchCount; ++i)
	{
		if (!(contact.patches[i].volume > 0)) continue;
		const ist::Vec3 centroid = contact.patches[i].firstMoment / contact.patches[i].volume;
		const ist::Vec3 arm = contact.X_WA * (contact.treeA->origin + centroid) - toVec3(rigid->getWorldTransform().getOrigin());
		sum += sign * (dot(contact.impulses[i].force, v + cross(w, arm)) + dot(contact.impulses[i].torque, w));
	}
	return sum;
}

void btEnergyAudit::beforeStep(double h)
{
	m_bodies.clear();
	const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i)
	{
		btRigidBody* body = movingBody(objects[i]);
		if (!body) continue;
		m_bodies.push_back({});
		m_bodies.back().body = body;
		m_bodies.back().gravity = toVec3(body->getGravity());
	}
	m_begin = energies();
	if (!m_first) m_open.injected += m_begin.sum() - m_end.sum();
	m_step = m_open;
	m_open = btEnergyBalance();
	for (Body& entry : m_bodies) enterForces(entry, h);
}

void btEnergyAudit::afterStep()
{
	double contact = 0, contactWork = 0;
	for (const btISTContact* c : m_store.contacts())
	{
		if (!c->work.acted) continue;
		contact += ist::pressureEnergy(c->total, {c->constants.k, c->constants.weightA, c->constants.weightB});
		if (c->stamp + 1 != m_store.step()) continue;
		const double moved = kinematicWork(*c, *c->bodyA, -1) + kinematicWork(*c, *c->bodyB, 1);
		m_open.physical -= c->work.damping + c->work.friction;
		m_open.numerical -= c->work.elastic;
		m_open.injected += moved;
		contactWork += c->work.elastic + c->work.damping + c->work.friction + moved;
	}
	for (int i = 0; i < m_world.getDispatcher()->getNumManifolds(); ++i)
	{
		const btPersistentManifold& manifold = *m_world.getDispatcher()->getManifoldByIndexInternal(i);
		const btISTContact* ours = m_store.find(&manifold);
		if (ours && ours->work.acted) continue;
		const double moved = ::kinematicWork(manifold);
		m_open.injected += moved;
		contactWork += moved;
	}
	for (const Body& entry : m_bodies)
	{
		m_open.residual += kineticEnergy(massOf(*entry.body), entry.inertia, twistOf(*entry.body)) -
			kineticEnergy(massOf(*entry.body), entry.inertia, entry.pushed);
		enterMotion(entry);
	}
	m_open.residual -= contactWork;
	m_end = energies();

	// The step before this one ends where this one began.
	m_step.kinetic = m_begin.kinetic;
	m_step.potential = m_begin.potential;
	m_step.contact = contact;
	if (m_first) m_step.injected = m_step.kinetic + m_step.potential + contact;
	else m_step.numerical -= contact - m_contact;
	m_contact = contact;
	m_first = false;
	addTo(m_total, m_step);
}
