// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btISTSubsteps.h"

#include "BulletISTCollision/Core/Tuning/StableTimeStep.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "BulletISTCollision/Registry/btISTShapeParts.h"

#include "BulletCollision/BroadphaseCollision/btBroadphaseInterface.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
constexpr int kMostEver = 1 << 20;  // a number of substeps that nobody will take, and an int can hold

bool hasTree(const btCollisionShape* shape, const btISTRegistry& registry)
{
	return btISTAnyPart(shape, [&](const btCollisionShape* part) { return registry.find(part) != nullptr; });
}

struct Velocity
{
	ist::Vec3 linear;
	double ofSurface = 0;  // by the spin [m/s]
};

Velocity velocityOf(const btCollisionObject* object)
{
	const btRigidBody* body = btRigidBody::upcast(object);
	if (!body) return {};
	const double spin = double(body->getAngularVelocity().length());
	return {toVec3(body->getLinearVelocity()), spin > 0 ? spin * double(body->getCollisionShape()->getAngularMotionDisc()) : 0};
}

/// What the broad phase finds in the box that a body sweeps.
struct Swept : btBroadphaseAabbCallback
{
	const btBroadphaseProxy* self;
	std::vector<const btCollisionObject*>& found;
	Swept(const btBroadphaseProxy* s, std::vector<const btCollisionObject*>& f) : self(s), found(f) {}
	bool process(const btBroadphaseProxy* proxy) override
	{
		const bool filtered = (proxy->m_collisionFilterGroup & self->m_collisionFilterMask) &&
			(self->m_collisionFilterGroup & proxy->m_collisionFilterMask);
		if (proxy != self && filtered) found.push_back(static_cast<const btCollisionObject*>(proxy->m_clientObject));
		return true;
	}
};

bool falls(const btCollisionObject* object) { return btRigidBody::upcast(object) && !object->isStaticOrKinematicObject(); }
}  // namespace

double btISTSubsteps::thickness(const btCollisionShape* shape, const btISTRegistry& registry)
{
	constexpr double kNone = std::numeric_limits<double>::infinity();
	if (const auto tree = registry.find(shape)) return ist::thicknessOf(*tree);
	if (shape->isCompound())
	{
		const auto* compound = static_cast<const btCompoundShape*>(shape);
		double least = kNone;
		for (int i = 0; i < compound->getNumChildShapes(); ++i) least = std::min(least, thickness(compound->getChildShape(i), registry));
		return least;
	}
	if (shape->isInfinite() || shape->isConcave()) return kNone;
	btVector3 lower, upper;
	shape->getAabb(btTransform::getIdentity(), lower, upper);
	const btVector3 size = upper - lower;
	return double(std::min({size.x(), size.y(), size.z()}));
}

void btISTSubsteps::addPair(
	const btCollisionObject* a, const btCollisionObject* b, const btISTRegistry& registry, double seconds, double gravity)
{
	const btCollisionShape *shapeA = a->getCollisionShape(), *shapeB = b->getCollisionShape();
	if (!hasTree(shapeA, registry) && !hasTree(shapeB, registry)) return;
	if (!a->checkCollideWith(b) || !b->checkCollideWith(a) || !a->hasContactResponse() || !b->hasContactResponse()) return;
	const double apart = falls(a) != falls(b) ? gravity * seconds : 0;
	const Velocity u = velocityOf(a), v = velocityOf(b);
	const double travel = (norm(u.linear - v.linear) + u.ofSurface + v.ofSurface + apart) * seconds;
	const double reach = ist::kMostTravel * std::min(thickness(shapeA, registry), thickness(shapeB, registry));
	if (!(travel > reach)) return;
	const int substeps = int(std::min(std::ceil(travel / reach), double(kMostEver)));
	const auto isKnown = [=](const btISTFastPair& known) { return known.first == b && known.second == a; };
	if (std::any_of(m_pairs.begin(), m_pairs.end(), isKnown)) return;
	m_pairs.push_back({a, b, substeps});
}

int btISTSubsteps::plan(btDiscreteDynamicsWorld& world, const btISTRegistry& registry, double seconds, int most)
{
	m_pairs.clear();
	if (registry.size() == 0) return 1;
	const btCollisionObjectArray& objects = world.getCollisionObjectArray();
	const double gravity = double(world.getGravity().length());
	double thinnest = std::numeric_limits<double>::infinity();
	for (int i = 0; i < objects.size(); ++i)
		if (hasTree(objects[i]->getCollisionShape(), registry))
			thinnest = std::min(thinnest, thickness(objects[i]->getCollisionShape(), registry));
	for (int i = 0; i < objects.size(); ++i)
	{
		const btCollisionObject* object = objects[i];
		const btBroadphaseProxy* proxy = object->getBroadphaseHandle();
		const Velocity u = velocityOf(object);
		const double travel = (norm(u.linear) + u.ofSurface + gravity * seconds) * seconds;
		const double least = std::min(thinnest, thickness(object->getCollisionShape(), registry));
		// Half: the other one may come to meet it just as fast.
		if (!proxy || !object->isActive() || !std::isfinite(travel) || !(travel > 0.5 * ist::kMostTravel * least)) continue;
		const btVector3 swept = toBullet(seconds * u.linear), aside = btVector3(1, 1, 1) * btScalar(travel - seconds * norm(u.linear));
		btVector3 lower = proxy->m_aabbMin, upper = proxy->m_aabbMax;
		lower.setMin(lower + swept);
		upper.setMax(upper + swept);
		m_near.clear();
		Swept callback(proxy, m_near);
		world.getBroadphase()->aabbTest(lower - aside, upper + aside, callback);
		for (const btCollisionObject* other : m_near) addPair(object, other, registry, seconds, gravity);
	}
	int needed = 1;
	for (const btISTFastPair& pair : m_pairs) needed = std::max(needed, pair.substeps);
	return std::min(needed, std::max(most, 1));
}
