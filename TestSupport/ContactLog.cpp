// SPDX-License-Identifier: Zlib
#include "TestSupport/ContactLog.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/NarrowPhaseCollision/btPersistentManifold.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace ist::test
{
namespace
{
Vec3 velocityAt(const btCollisionObject& object, const Vec3& point)
{
	const btRigidBody* body = btRigidBody::upcast(&object);
	return body ? toVec3(body->getVelocityInLocalPoint(toBullet(point) - body->getCenterOfMassPosition())) : Vec3();
}

double slipOf(const ContactRecord& record, const Vec3& point, const Vec3& normal, double h)
{
	const Vec3 v = velocityAt(*record.a, point) - velocityAt(*record.b, point);
	return norm(v - dot(v, normal) * normal) * h;
}

Vec3 impulseOnA(const btPersistentManifold& manifold)
{
	Vec3 sum;
	for (int i = 0; i < manifold.getNumContacts(); ++i)
	{
		const btManifoldPoint& point = manifold.getContactPoint(i);
		sum += double(point.m_appliedImpulse) * toVec3(point.m_normalWorldOnB) +
			double(point.m_appliedImpulseLateral1) * toVec3(point.m_lateralFrictionDir1) +
			double(point.m_appliedImpulseLateral2) * toVec3(point.m_lateralFrictionDir2);
	}
	return sum;
}

/// True when the body moves and does not sleep. Bullet solves no pair without such a body: its impulses and depths are then those of the
/// step in which it fell asleep.
bool isAwake(const btCollisionObject* body) { return body->isActive() && !body->isStaticObject(); }

bool isNowhere(const btCollisionObject& object)
{
	const btRigidBody* body = btRigidBody::upcast(&object);
	return !isFinite(toVec3(object.getWorldTransform().getOrigin())) ||
		(body && !(isFinite(toVec3(body->getLinearVelocity())) && isFinite(toVec3(body->getAngularVelocity()))));
}

bool involves(const ContactRecord& record, const btCollisionObject* body) { return !body || record.a == body || record.b == body; }
}  // namespace

void ContactLog::record(double h)
{
	m_time += h;
	const btDispatcher* dispatcher = m_world.getDispatcher();
	const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i) m_blownUp = m_blownUp || isNowhere(*objects[i]);
	for (const btISTContact* contact : m_store.contacts())
		if (contact->total.volume > 0 && contact->stamp + 1 >= m_store.step() && (isAwake(contact->bodyA) || isAwake(contact->bodyB)))
			add(*contact, h);
	for (int i = 0; i < dispatcher->getNumManifolds(); ++i)
	{
		const btPersistentManifold* manifold = const_cast<btDispatcher*>(dispatcher)->getManifoldByIndexInternal(i);
		const btISTContact* ours = m_store.find(manifold);
		if (manifold->getNumContacts() == 0 || (ours && ours->total.volume > 0)) continue;
		if (isAwake(manifold->getBody0()) || isAwake(manifold->getBody1())) add(*manifold, h);
	}
}

void ContactLog::add(const btISTContact& contact, double h)
{
	ContactRecord record;
	record.time = m_time;
	record.a = contact.bodyA;
	record.b = contact.bodyB;
	record.volumetric = true;
	record.volume = contact.total.volume;
	const double area = norm(contact.total.areaVector);
	if (contact.work.acted || contact.normalImpulse != 0)
		for (int i = 0; i < contact.patchCount; ++i) record.impulseOnA += contact.impulses[i].force;
	else  // Bullet's solver pushed at the representative points
		record.impulseOnA = impulseOnA(*contact.manifold);
	record.depth = larger(0, (contact.total.depthA + contact.total.depthB) / contact.total.volume);
	if (area > 0)
	{
		const Vec3 centroid = contact.treeA->origin + (1 / contact.total.volume) * contact.total.firstMoment;
		record.slip = slipOf(record, contact.X_WA * centroid, contact.X_WA.rotation * ((1 / area) * contact.total.areaVector), h);
	}
	m_records.push_back(record);
}

void ContactLog::add(const btPersistentManifold& manifold, double h)
{
	ContactRecord record;
	record.time = m_time;
	record.a = manifold.getBody0();
	record.b = manifold.getBody1();
	record.impulseOnA = impulseOnA(manifold);
	Vec3 middle, normal;
	const double share = 1.0 / manifold.getNumContacts();
	for (int i = 0; i < manifold.getNumContacts(); ++i)
	{
		const btManifoldPoint& point = manifold.getContactPoint(i);
		const Vec3 onB = toVec3(point.m_normalWorldOnB);
		record.depth = larger(record.depth, -double(point.getDistance()));
		middle += share * toVec3(point.getPositionWorldOnB());
		normal += share * onB;
	}
	// Points that are about to touch are not a contact yet.
	if (record.depth <= 0 && norm(record.impulseOnA) <= 0) return;
	record.slip = norm(normal) > 0 ? slipOf(record, middle, normalized(normal), h) : 0;
	m_records.push_back(record);
}

void ContactLog::clear()
{
	m_records.clear();
	m_time = 0;
	m_blownUp = false;
}

double ContactLog::deepest(const btCollisionObject* body) const
{
	double most = m_blownUp ? std::numeric_limits<double>::quiet_NaN() : 0;
	for (const ContactRecord& record : m_records)
		if (involves(record, body)) most = larger(most, record.depth);
	return most;
}

double ContactLog::slip(const btCollisionObject* body) const
{
	// When a pair has several records in a step, the longest path counts. It is known when the step is over.
	struct Way
	{
		double before = 0, now = 0, time = 0;
	};
	std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, Way> ways;
	double most = m_blownUp ? std::numeric_limits<double>::quiet_NaN() : 0;
	for (const ContactRecord& record : m_records)
	{
		if (!involves(record, body)) continue;
		Way& way = ways[std::minmax(record.a, record.b)];
		if (way.time != record.time) way = {way.before + way.now, 0, record.time};
		way.now = larger(way.now, record.slip);
		most = larger(most, way.before + way.now);
	}
	return most;
}

Vec3 ContactLog::impulseOn(const btCollisionObject* body) const
{
	Vec3 sum;
	for (const ContactRecord& record : m_records)
	{
		if (record.a == body) sum += record.impulseOnA;
		if (record.b == body) sum -= record.impulseOnA;
	}
	return sum;
}

bool ContactLog::haveTouched(const btCollisionObject* a, const btCollisionObject* b) const
{
	return std::any_of(
		m_records.begin(), m_records.end(), [&](const ContactRecord& r) { return (r.a == a && r.b == b) || (r.a == b && r.b == a); });
}
}  // namespace ist::test
