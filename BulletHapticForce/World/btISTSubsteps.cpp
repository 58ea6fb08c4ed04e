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
constexpr int kMostEver = 1 << 20;  // a number of substeps that is never needed, and fits into an int

bool hasTree(const btCollisionShape* shape, const btISTRegistry& registry)
{
	return btISTAnyPart(shape, [&](const btCollisionShape* part) { return registry.find(part) != nullptr; });
}

struct Velocity
{
	ist::Vec3 linear;
	double ofSurface = 0;  // speed of the surface by the spin [m/s]
};

Velocity velocityOf(const btCollisionObject* object)
{
	const btRigidBody* body = btRigidBody::upcast(object);
	if (!body) return {};
	const double spin = double(body->getAngularVelocity().length());
	return {toVec3(body->getLinearVelocity()), spin > 0 ? spin * double(body->getCollisionShape()->getAngularMotionDisc()) : 0};
}

/// Collects the objects that the broad phase finds in the box that a body sweeps.
struct Swept : btBroadphaseAabbCallback
{
	const btBroadphaseProxy* self;
	const btCollisionObjectArray& objects;
	std::vector<int>& found;
	Swept(const btBroadphaseProxy* s, const btCollisionObjectArray& o, std::vector<int>& f) : self(s), objects(o), found(f) {}
	bool process(const btBroadphaseProxy* proxy) override
	{
		const bool filtered = (proxy->m_collisionFilterGroup & self->m_collisionFilterMask) &&
			(self->m_collisionFilterGroup & proxy->m_collisionFilterMask);
		if (proxy == self || !filtered) return true;
		const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
		const int place = object->getWorldArrayIndex();
		if (place >= 0 && place < objects.size() && objects[place] == object) found.push_back(place);
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

double btISTSubsteps::measureBodies(const btCollisionObjectArray& objects, const btISTRegistry& registry)
{
	double thinnest = std::numeric_limits<double>::infinity();
	m_bodies.resize(size_t(objects.size()));
	for (int i = 0; i < objects.size(); ++i)
	{
		const btCollisionShape* shape = objects[i]->getCollisionShape();
		Body& body = m_bodies[size_t(i)];
		body = {thickness(shape, registry), hasTree(shape, registry)};
		if (body.hasTree) thinnest = std::min(thinnest, body.thickness);
	}
	return thinnest;
}

/// Finds the bodies that a body may touch, and leaves them in `m_near` in the order of the world.
void btISTSubsteps::findNear(btDiscreteDynamicsWorld& world, int body, double travel, double seconds)
{
	const btCollisionObject* object = world.getCollisionObjectArray()[body];
	const btBroadphaseProxy* proxy = object->getBroadphaseHandle();
	const ist::Vec3 velocity = velocityOf(object).linear;
	const btVector3 swept = toBullet(seconds * velocity), aside = btVector3(1, 1, 1) * btScalar(travel - seconds * norm(velocity));
	btVector3 lower = proxy->m_aabbMin, upper = proxy->m_aabbMax;
	lower.setMin(lower + swept);
	upper.setMax(upper + swept);
	m_near.clear();
	Swept callback(proxy, world.getCollisionObjectArray(), m_near);
	world.getBroadphase()->aabbTest(lower - aside, upper + aside, callback);
	std::sort(m_near.begin(), m_near.end(), [this](int a, int b) { return ++m_comparisons, a < b; });
}

/// True when `first` has found `second` before.
bool btISTSubsteps::isKnown(int first, int second)
{
	const Body& body = m_bodies[size_t(first)];
	const auto begin = m_pairs.begin() + ptrdiff_t(body.firstPair), end = m_pairs.begin() + ptrdiff_t(body.pairsEnd);
	const auto isBefore = [this](
							  const btISTFastPair& pair, int place) { return ++m_comparisons, pair.second->getWorldArrayIndex() < place; };
	const auto found = std::lower_bound(begin, end, second, isBefore);
	return found != end && found->second->getWorldArrayIndex() == second;
}

void btISTSubsteps::addPair(const btCollisionObjectArray& objects, int first, int second, double seconds, double gravity)
{
	const btCollisionObject *a = objects[first], *b = objects[second];
	const Body &bodyA = m_bodies[size_t(first)], &bodyB = m_bodies[size_t(second)];
	if (!bodyA.hasTree && !bodyB.hasTree) return;
	const double apart = falls(a) != falls(b) ? gravity * seconds : 0;
	const Velocity u = velocityOf(a), v = velocityOf(b);
	const double travel = (norm(u.linear - v.linear) + u.ofSurface + v.ofSurface + apart) * seconds;
	const double reach = ist::kMostTravel * std::min(bodyA.thickness, bodyB.thickness);
	if (!(travel > reach) || isKnown(second, first)) return;
	if (!a->checkCollideWith(b) || !b->checkCollideWith(a) || !a->hasContactResponse() || !b->hasContactResponse()) return;
	m_pairs.push_back({a, b, int(std::min(std::ceil(travel / reach), double(kMostEver)))});
}

int btISTSubsteps::plan(btDiscreteDynamicsWorld& world, const btISTRegistry& registry, double seconds, int most)
{
	m_pairs.clear();
	m_comparisons = 0;
	if (registry.size() == 0) return 1;
	const btCollisionObjectArray& objects = world.getCollisionObjectArray();
	const double gravity = double(world.getGravity().length()), thinnest = measureBodies(objects, registry);
	if (std::none_of(m_bodies.begin(), m_bodies.end(), [](const Body& body) { return body.hasTree; })) return 1;
	for (int i = 0; i < objects.size(); ++i)
	{
		const btCollisionObject* object = objects[i];
		const Velocity u = velocityOf(object);
		const double travel = (norm(u.linear) + u.ofSurface + gravity * seconds) * seconds;
		const double least = std::min(thinnest, m_bodies[size_t(i)].thickness);
		// The factor is one half, because the other body may come towards it just as fast.
		if (!object->getBroadphaseHandle() || !object->isActive() || !std::isfinite(travel) || !(travel > 0.5 * ist::kMostTravel * least))
			continue;
		findNear(world, i, travel, seconds);
		m_bodies[size_t(i)].firstPair = m_pairs.size();
		for (const int other : m_near) addPair(objects, i, other, seconds, gravity);
		m_bodies[size_t(i)].pairsEnd = m_pairs.size();
	}
	int needed = 1;
	for (const btISTFastPair& pair : m_pairs) needed = std::max(needed, pair.substeps);
	return std::min(needed, std::max(most, 1));
}
