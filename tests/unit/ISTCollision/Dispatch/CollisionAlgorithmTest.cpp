// SPDX-License-Identifier: Zlib
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/ISTCollision/Dispatch/AlgorithmWorld.h"
#include "tests/unit/ISTCollision/Registry/BulletMesh.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>

#include <cmath>
#include <optional>
#include <vector>

namespace
{
std::vector<btTransform> pileAfterASecond(bool registered)
{
	TestWorld w;
	btISTRegistration r;
	if (registered) r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btBoxShape box(btVector3(.5, .5, .5));
	btSphereShape sphere(btScalar(.4));
	btCompoundShape compound;
	compound.addChildShape(at(-.6, 0, 0), &box);
	compound.addChildShape(at(.6, 0, 0), &sphere);
	w.add(&plane, 0, at(0, 0, 0));
	for (int i = 0; i < 12; ++i)
		w.add(i % 3 == 0     ? static_cast<btCollisionShape*>(&box)
				: i % 3 == 1 ? static_cast<btCollisionShape*>(&sphere)
							 : &compound,
			1, at(.13 * i, .8 + .9 * i, .07 * i));
	w.step(120);
	std::vector<btTransform> poses;
	for (auto& b : w.bodies) poses.push_back(b->getWorldTransform());
	return poses;
}
}  // namespace

TEST(btISTCollisionAlgorithm, LeavesAWorldWithoutTreesAsItWasBitForBit)
{
	const auto without = pileAfterASecond(false), with = pileAfterASecond(true);
	ASSERT_EQ(without.size(), with.size());
	for (size_t i = 0; i < with.size(); ++i)
		for (int row = 0; row < 4; ++row)
		{
			const btVector3 a = row < 3 ? without[i].getBasis()[row] : without[i].getOrigin();
			const btVector3 b = row < 3 ? with[i].getBasis()[row] : with[i].getOrigin();
			for (int c = 0; c < 3; ++c) EXPECT_EQ(a[c], b[c]) << "body " << i;
		}
}

TEST(btISTCollisionAlgorithm, RayTestStillHitsTheShape)
{
	TestWorld w;
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	btBoxShape box(btVector3(.5, .5, .5));
	const auto keep = attach(r, box);
	w.add(&box, 0, at(0, 0, 0));
	const btVector3 from(0, 3, 0), to(0, -3, 0);
	btCollisionWorld::ClosestRayResultCallback hit(from, to);
	w.world->rayTest(from, to, hit);
	ASSERT_TRUE(hit.hasHit());
	EXPECT_NEAR(double(hit.m_hitPointWorld.y()), .5, 1e-5);
}

TEST(btISTCollisionAlgorithm, BoxRestsOnAPlaneWithTheStockSolverInBothOrders)
{
	for (const bool planeFirst : {true, false})
	{
		TestWorld w;
		auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
		btStaticPlaneShape plane(btVector3(0, 1, 0), btScalar(.25));
		btBoxShape box(btVector3(.5, .5, .5));
		const auto keep = attach(r, box);
		if (planeFirst) w.add(&plane, 0, at(0, 1, 0));
		btRigidBody* body = w.add(&box, 3, at(.1, 1.8, .2));
		if (!planeFirst) w.add(&plane, 0, at(0, 1, 0));
		body->setActivationState(DISABLE_DEACTIVATION);
		w.step(300);

		double impulse = 0;
		for (int i = 0; i < 60; ++i)
		{
			w.step(1);
			ASSERT_EQ(r.store().contacts().size(), 1u);
			const btISTContact& c = *r.store().contacts()[0];
			EXPECT_EQ(c.bodyA, body);
			EXPECT_TRUE(c.halfSpace);
			for (int p = 0; p < c.manifold->getNumContacts(); ++p) impulse += double(c.manifold->getContactPoint(p).m_appliedImpulse);
		}
		EXPECT_NEAR(impulse, 3 * 9.81, .05 * 3 * 9.81);
		EXPECT_LT(body->getLinearVelocity().length(), .01);
		EXPECT_LT(body->getAngularVelocity().length(), .02);
		EXPECT_GT(double(body->getWorldTransform().getOrigin().y()), 1.65);
		EXPECT_LT(double(body->getWorldTransform().getOrigin().y()), 1.76);
	}
}

TEST(btISTCollisionAlgorithm, WorksForAChildOfACompoundAndOfANestedOne)
{
	for (const bool nested : {false, true})
	{
		TestWorld w;
		auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
		btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
		btBoxShape volumetric(btVector3(.5, .5, .5)), plain(btVector3(.5, .5, .5));
		const auto keep = attach(r, volumetric);
		btCompoundShape inner, outer;
		inner.addChildShape(at(-1, 0, 0), &volumetric);
		inner.addChildShape(at(1, 0, 0), &plain);
		outer.addChildShape(at(0, 0, 0), &inner);
		w.add(&plane, 0, at(0, 0, 0));
		btRigidBody* a = w.add(nested ? &outer : &inner, 2, at(0, .6, 0));
		btRigidBody* b = w.add(nested ? &outer : &inner, 2, at(0, 1.65, 0));
		w.step(240);
		EXPECT_GE(r.store().contacts().size(), 2u);
		EXPECT_NEAR(double(a->getWorldTransform().getOrigin().y()), .5, .15);
		EXPECT_NEAR(double(b->getWorldTransform().getOrigin().y()), 1.5, .25);
		w.world->removeRigidBody(b);
		w.world->addRigidBody(b);
		w.step(10);
		EXPECT_NEAR(double(b->getWorldTransform().getOrigin().y()), 1.5, .25);
	}
}

// GImpact has its own algorithm for a mesh on a compound, which does not consult the dispatcher about the children.
TEST(btISTCollisionAlgorithm, WorksForAChildOfACompoundOnAGImpactMesh)
{
	const BulletMesh triangles(ist::makeBoxMesh({0.5, 0.5, 0.5}));
	for (const bool compoundFirst : {false, true})
	{
		TestWorld w;
		btGImpactCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
		auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, w.broadphase.getOverlappingPairCache());
		btGImpactMeshShape mesh(triangles.interface());
		mesh.updateBound();
		btBoxShape volumetric(btVector3(.5, .5, .5)), plain(btVector3(.5, .5, .5));
		btCompoundShape compound;
		compound.addChildShape(at(-1, 0, 0), &volumetric);
		compound.addChildShape(at(1, 0, 0), &plain);
		if (compoundFirst) w.add(&compound, 0, at(1, .9, 0));
		w.add(&mesh, 1, at(0, 0, 0));
		if (!compoundFirst) w.add(&compound, 0, at(1, .9, 0));
		w.step(1);
		EXPECT_EQ(r.store().contacts().size(), 0u) << "nothing is attached";
		EXPECT_GT(w.points(), 0);
		const auto keep = attach(r, mesh), keepToo = attach(r, volumetric);
		w.bodies[compoundFirst ? 1 : 0]->setWorldTransform(at(0, 0, 0));
		w.step(1);
		double volume = 0;
		for (const btISTContact* contact : r.store().contacts()) volume += contact->total.volume;
		EXPECT_NEAR(volume, 0.1, 0.01);  // volume of a layer of a tenth of the cube
	}
}

TEST(btISTCollisionAlgorithm, RemovalFreesTheContactAndReaddingBringsItBack)
{
	TestWorld w;
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	btBoxShape box(btVector3(.5, .5, .5));
	const auto keep = attach(r, box);
	w.add(&box, 0, at(0, 0, 0));
	btRigidBody* upper = w.add(&box, 1, at(0, .95, 0));
	for (int round = 0; round < 3; ++round)
	{
		w.step(2);
		EXPECT_EQ(r.store().contacts().size(), 1u);
		w.world->removeRigidBody(upper);
		EXPECT_EQ(r.store().contacts().size(), 0u);
		EXPECT_EQ(w.dispatcher.getNumManifolds(), 0);
		w.world->addRigidBody(upper);
	}
}

TEST(btISTCollisionAlgorithm, LateAttachmentTakesEffectAndDetachmentToo)
{
	TestWorld w;
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, w.broadphase.getOverlappingPairCache());
	btBoxShape box(btVector3(.5, .5, .5));
	w.add(&box, 0, at(0, 0, 0));
	w.add(&box, 1, at(0, .99, 0));
	w.step(2);
	EXPECT_EQ(r.store().contacts().size(), 0u);
	EXPECT_GT(w.points(), 0);
	auto keep = attach(r, box);
	w.step(5);
	EXPECT_EQ(r.store().contacts().size(), 1u);
	keep.detach();
	EXPECT_EQ(r.store().contacts().size(), 0u);
	w.step(1);
	EXPECT_GT(w.points(), 0);
}

TEST(btISTCollisionAlgorithm, KinematicToolWakesASleeper)
{
	TestWorld w;
	w.world->setGravity(btVector3(0, 0, 0));
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	btBoxShape box(btVector3(.5, .5, .5));
	const auto keep = attach(r, box);
	btRigidBody* sleeper = w.add(&box, 1, at(0, 0, 0));
	btRigidBody* tool = w.add(&box, 0, at(0, 3, 0));
	tool->setCollisionFlags(tool->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
	tool->setActivationState(DISABLE_DEACTIVATION);
	sleeper->forceActivationState(ISLAND_SLEEPING);
	w.step(2);
	ASSERT_FALSE(sleeper->isActive());
	for (int i = 0; i < 60; ++i)
	{
		tool->setWorldTransform(at(0, 3 - 2.2 * (i + 1) / 60, 0));
		w.step(1);
	}
	EXPECT_TRUE(sleeper->isActive());
	EXPECT_LT(double(sleeper->getWorldTransform().getOrigin().y()), -.01);
}

TEST(btISTCollisionAlgorithm, ContactCallbacksTellOfOneBeginningAndOneEnd)
{
	static int started, ended;
	started = ended = 0;
	gContactStartedCallback = [](btPersistentManifold* const&) { ++started; };
	gContactEndedCallback = [](btPersistentManifold* const&) { ++ended; };
	{
		TestWorld w;
		w.world->setGravity(btVector3(0, 0, 0));
		auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
		btBoxShape box(btVector3(.6, .6, .6));
		const auto keep = attach(r, box);
		w.add(&box, 0, at(0, 0, 0));
		btRigidBody* upper = w.add(&box, 1, at(0, .95, 0));
		for (int i = 0; i < 20; ++i)
		{
			upper->setWorldTransform(at(.001 * i, .95, 0));
			w.world->performDiscreteCollisionDetection();
		}
		EXPECT_EQ(started, 1);
		EXPECT_EQ(ended, 0);
		// At this distance the leaves are apart, although they reach beyond the surface, but the bounding boxes of the broad phase meet.
		upper->setWorldTransform(at(0, 1.12, 0));
		w.world->performDiscreteCollisionDetection();
		EXPECT_EQ(ended, 1);
		EXPECT_EQ(w.points(), 0);
		EXPECT_EQ(r.store().contacts().size(), 1u) << "a separated pair keeps its empty manifold";
	}
	gContactStartedCallback = nullptr;
	gContactEndedCallback = nullptr;
}

TEST(btISTCollisionAlgorithm, SurvivesDestructionInEveryOrder)
{
	for (int order = 0; order < 6; ++order)
	{
		auto w = std::make_unique<TestWorld>();
		std::optional<btISTRegistration> r = btISTCollisionAlgorithm::registerAlgorithm(
			&w->dispatcher, w->broadphase.getOverlappingPairCache());
		auto box = std::make_unique<btBoxShape>(btVector3(.5, .5, .5));
		btISTAttachment keep = attach(*r, *box);
		w->add(box.get(), 0, at(0, 0, 0));
		w->add(box.get(), 1, at(0, .95, 0));
		w->step(2);
		const auto destroyWorld = [&] {
			if (r) r->dispatcherIsGone();
			w.reset();
		};
		const int steps[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
		for (const int what : steps[order])
		{
			if (what == 0) keep.detach();
			if (what == 1) r.reset();
			if (what == 2) destroyWorld();
			if (w) w->step(2);
		}
	}
}

TEST(btISTCollisionAlgorithm, GateShutsOutWhatOnlyTouches)
{
	TestWorld w;
	btISTRegistration r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	btBoxShape shape(btVector3(.5, .5, .5));
	const btISTAttachment attachment = attach(r, shape, leavesOfBox());
	w.add(&shape, 0, at(0, 0, 0));
	btRigidBody* const upper = w.add(&shape, 1, at(.1, 1, .1));
	const auto volumeAt = [&](double height, bool gate) {
		r.requireInnerOverlap(gate);
		upper->setWorldTransform(at(.1, height, .1));
		w.world->performDiscreteCollisionDetection();
		return r.store().contacts().empty() ? -1 : r.store().contacts()[0]->total.volume;
	};
	EXPECT_GT(volumeAt(1, false), 0) << "nothing to shut out";
	EXPECT_EQ(volumeAt(1, true), 0);
	EXPECT_EQ(volumeAt(.8, true), volumeAt(.8, false));
	EXPECT_GT(volumeAt(.8, true), 0);
}

TEST(btISTCollisionAlgorithm, AcceptedErrorChoosesTheLevelOfEachPairAndFades)
{
	TestWorld w;
	btISTRegistration r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, w.broadphase.getOverlappingPairCache());
	btBoxShape lowerShape(btVector3(.5, .5, .5)), upperShape(btVector3(.5, .5, .5));
	const btISTAttachment lower = attach(r, lowerShape, leavesOfBox()), upper = attach(r, upperShape, leavesOfBox());
	w.add(&lowerShape, 0, at(0, 0, 0));
	btRigidBody* const body = w.add(&upperShape, 1, at(.1, .7, .1));
	const auto look = [&](int steps) -> const btISTContact& {
		for (int i = 0; i < steps; ++i) w.world->performDiscreteCollisionDetection();
		return *r.store().contacts().at(0);
	};
	const auto forceOf = [](const btISTContact& c) { return ist::pressureWrench(c.total, {1, .5, .5}).force; };
	const ist::Vec3 leaves = forceOf(look(2));
	const int64_t all = look(1).total.pairs;
	EXPECT_EQ(look(1).accuracy.level, -1) << "nothing is chosen unless asked for";

	for (const double bad : {-.1, 1.1, std::nan("")}) EXPECT_TRUE(r.setForceError(bad));
	EXPECT_EQ(r.forceError(), 0);
	EXPECT_FALSE(r.setForceError(1e-4));
	EXPECT_EQ(look(1).total.pairs, all) << "what cannot be kept is answered by the leaves";
	EXPECT_FALSE(look(1).accuracy.kept);

	EXPECT_FALSE(r.setForceError(.3));
	const long before = allocationCount();
	ist::Vec3 last = leaves;
	for (int i = 0; i < 300; ++i)
	{
		const ist::Vec3 force = forceOf(look(1));
		EXPECT_LE(ist::norm(force - last), .01 * ist::norm(last)) << "step " << i;
		last = force;
	}
	EXPECT_EQ(allocationCount(), before);
	const btISTContact& coarse = look(1);
	EXPECT_EQ(coarse.accuracy.fadedShare, 0);
	EXPECT_GT(coarse.accuracy.level, 0);
	EXPECT_TRUE(coarse.accuracy.kept);
	EXPECT_LE(coarse.accuracy.errorBound, .3);
	EXPECT_LT(double(coarse.total.pairs), .5 * double(all));
	EXPECT_LE(ist::norm(forceOf(coarse) - leaves), .3 * ist::norm(leaves));

	for (const double share : {0., .3, 0.})
	{
		EXPECT_FALSE(r.setForceError(share));
		for (int i = 0; i < 300; ++i)
		{
			const ist::Vec3 force = forceOf(look(1));
			EXPECT_LE(ist::norm(force - last), .01 * ist::norm(last)) << "to " << share << " step " << i;
			last = force;
		}
		EXPECT_EQ(look(1).accuracy.level > 0, share > 0);
	}
	EXPECT_EQ(look(1).total.pairs, all);
	EXPECT_EQ(look(1).accuracy.level, -1);
	body->setWorldTransform(at(.1, 5, .1));
	EXPECT_FALSE(r.setForceError(.3));
	w.world->performDiscreteCollisionDetection();
}

TEST(btISTCollisionAlgorithm, PoseThatIsNotFiniteGivesAnEmptyContact)
{
	TestWorld w;
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	btBoxShape box(btVector3(.5, .5, .5));
	const auto keep = attach(r, box);
	btCollisionObject a, b;
	a.setCollisionShape(&box);
	b.setCollisionShape(&box);
	b.setWorldTransform(at(0, std::nan(""), 0));
	CollectPoints query;
	w.world->contactPairTest(&a, &b, query);
	EXPECT_EQ(query.count, 0);
}
