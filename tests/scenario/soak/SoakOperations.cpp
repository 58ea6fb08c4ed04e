// SPDX-License-Identifier: Zlib
#include "tests/scenario/soak/SoakOperations.h"

#include "BulletCollision/Gimpact/btGImpactShape.h"

#include <iterator>
#include <limits>

using namespace scenario;

namespace soak
{
namespace
{
constexpr size_t kMostActors = 16;
constexpr btScalar kNan = std::numeric_limits<btScalar>::quiet_NaN(), kInfinity = std::numeric_limits<btScalar>::infinity();

Actor* anyActor(SoakWorld& world, Random& random)
{
	if (world.actors().empty()) return nullptr;
	return &*std::next(world.actors().begin(), below(random, int(world.actors().size())));
}

/// Scales a body. A tree is valid only for the scaling for which it was made: Bullet's own contact acts until the body has that scaling
/// again.
void scale(SoakWorld& world, Actor& actor, Random& random)
{
	const bool isOne = btISTRegistry::hasScaling(*actor.shape(), btVector3(1, 1, 1));
	const btScalar s = btScalar(isOne ? between(random, 0.7, 1.2) : 1);
	actor.shape()->setLocalScaling(btVector3(s, s, s));
	if (actor.shape()->getShapeType() == GIMPACT_SHAPE_PROXYTYPE) static_cast<btGImpactMeshShape*>(actor.shape())->updateBound();
	world.bullet().updateSingleAabb(actor.body.get());
}

void setMaterial(SoakWorld& world, Actor& actor, Random& random)
{
	if (below(random, 3) == 0) return world.ist().materials().remove(actor.body.get());
	const btContactMaterial material{std::pow(10, between(random, 3, 9)), below(random, 2) ? -1 : between(random, 0, 2)};
	EXPECT_FALSE(world.ist().materials().set(actor.body.get(), material));
}

void changeSettings(SoakWorld& world, Random& random)
{
	btISTWorld& ist = world.ist();
	switch (below(random, 6))
	{
	case 0: EXPECT_FALSE(ist.setContactCache({below(random, 4) > 0, between(random, 0, 0.1)})); break;
	case 1: EXPECT_FALSE(ist.setForceError(below(random, 2) ? 0.05 : 0)); break;
	case 2: ist.registration().requireInnerOverlap(below(random, 2)); break;
	case 3: EXPECT_FALSE(ist.pairFilter().setRegion(btVector3(-1, 0, -1), btVector3(1, 2, 1))); break;
	case 4: ist.pairFilter().clearRegion(); break;
	default: ist.setMostSubsteps(1 + below(random, 3));
	}
}

void contactTests(SoakWorld& world, Actor& a, Actor& b)
{
	struct Count : btCollisionWorld::ContactResultCallback
	{
		bool finite = true;
		btScalar addSingleResult(
			btManifoldPoint& p, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int) override
		{
			finite = finite && std::isfinite(p.getDistance());
			return 0;
		}
	};
	Count whole, pair;
	world.bullet().contactTest(a.body.get(), whole);
	if (&a != &b) world.bullet().contactPairTest(a.body.get(), b.body.get(), pair);
	EXPECT_TRUE(whole.finite && pair.finite);
}
}  // namespace

void disturb(SoakWorld& world, Random& random, Tally& tally)
{
	++tally.operations;
	Actor *one = anyActor(world, random), *other = anyActor(world, random);
	const int what = below(random, 16);
	if (!one || (what < 2 && world.actors().size() < kMostActors)) return void(world.add(random, below(random, 3) > 0));
	switch (what)
	{
	case 0:
	case 1:
	case 2: return world.remove(*one);
	case 3:
		for (Actor::Part& part : one->parts) part.attachment.detach();
		return;
	case 4:
	case 5:
		for (Actor::Part& part : one->parts)
			if (btISTRegistry::hasScaling(*part.shape, btVector3(1, 1, 1))) world.attach(part);
		return;
	case 6: return one->body->forceActivationState(ISLAND_SLEEPING);
	case 7: return one->body->activate(true);
	case 8: return world.place(*one, world.somewhere(random));
	case 9: return world.place(*one, other->body->getWorldTransform());  // one body inside the other
	case 10: return scale(world, *one, random);
	case 11: return setMaterial(world, *one, random);
	case 12: return world.joints() < 3 ? world.join(*one, *other) : world.separate();
	case 13: return changeSettings(world, random);
	case 14: return contactTests(world, *one, *other);
	default:
		if (below(random, 8) == 0) return world.reinstall();
		return one->body->applyCentralImpulse(vec(randomVector(random, 8)));
	}
}

Actor* poison(SoakWorld& world, Random& random, Tally& tally)
{
	Actor* actor = anyActor(world, random);
	if (!actor) return nullptr;
	++tally.poisoned;
	btRigidBody& body = *actor->body;
	const btVector3 place = body.getWorldTransform().getOrigin();
	const btScalar bad[] = {kNan, kInfinity, -kInfinity, btScalar(1e12)};
	const btScalar value = bad[below(random, 4)];
	body.activate(true);
	switch (below(random, 6))
	{
	case 0: body.setLinearVelocity(btVector3(0, value, 0)); break;
	case 1: body.setAngularVelocity(btVector3(value, 0, 1)); break;
	case 2: world.place(*actor, btTransform(btQuaternion::getIdentity(), btVector3(place.x(), value, place.z()))); break;
	case 3: world.place(*actor, btTransform(btMatrix3x3(value, 0, 0, 0, 1, 0, 0, 0, 1), place)); break;
	case 4: body.applyCentralForce(btVector3(value, value, 0)); break;
	default: body.applyTorque(btVector3(0, 0, value));
	}
	actor->poisoned = true;
	return actor;
}

void expectRefusals(SoakWorld& world, Random& random, Tally& tally)
{
	btISTWorld& ist = world.ist();
	const btBoxShape box(btVector3(1, 1, 1));
	const btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	++tally.refused;
	const double nan = double(kNan);
	switch (below(random, 8))
	{
	case 0: EXPECT_FALSE(ist.attach(nullptr, cube().tree)); break;
	case 1: EXPECT_FALSE(ist.attach(&box, TreePtr())); break;
	case 2: EXPECT_FALSE(ist.attach(&plane, cube().tree)); break;
	case 3: EXPECT_FALSE(ist.attach(&box, "/nonexistent/tree.ist")); break;
	case 4: EXPECT_TRUE(ist.step(below(random, 2) ? nan : -1)); break;
	case 5: EXPECT_TRUE(ist.setGravity(btVector3(kNan, 0, kInfinity))); break;
	case 6: EXPECT_TRUE(ist.materials().set(nullptr, {1, 1})); break;
	default: EXPECT_TRUE(ist.pairFilter().setRegion(btVector3(kNan, 0, 0), btVector3(1, 1, 1)));
	}
}
}  // namespace soak
