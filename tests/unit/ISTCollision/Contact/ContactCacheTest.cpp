// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Contact/btISTContactCache.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

namespace
{
/// The tree of a cube of side 1.
std::shared_ptr<const ist::InnerSphereTree> cubeTree()
{
	static const auto tree = [] {
		ist::BuildOptions options;
		options.maxSpheres = 500;
		return std::make_shared<const ist::InnerSphereTree>(ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options).value());
	}();
	return tree;
}

/// The same tree has no surface here, so that contact is that of the leaves.
std::shared_ptr<const ist::InnerSphereTree> leafTree()
{
	static const auto tree = [] {
		auto made = std::make_shared<ist::InnerSphereTree>(*cubeTree());
		made->surface = {};
		return made;
	}();
	return tree;
}

btVector3 vec(double x, double y, double z) { return btVector3(btScalar(x), btScalar(y), btScalar(z)); }
btTransform at(const btVector3& p, const btVector3& turn = btVector3(0, 0, 0))
{
	const btScalar angle = turn.length();
	return btTransform(angle > 0 ? btQuaternion(turn / angle, angle) : btQuaternion::getIdentity(), p);
}

/// A cube with a tree above another shape, which may have a tree too.
struct Pair
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btCollisionWorld world{&dispatcher, &broadphase, &configuration};
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher);
	btBoxShape cube{vec(.5, .5, .5)};
	btISTAttachment attachment;
	btCollisionObject upper, lower;

	explicit Pair(const btISTContactCache& contactCache, btCollisionShape* under = nullptr,
		const std::shared_ptr<const ist::InnerSphereTree>& tree = cubeTree())
		: attachment(registration.registry().attach(&cube, tree).value())
	{
		EXPECT_FALSE(registration.setContactCache(contactCache));
		upper.setCollisionShape(&cube);
		lower.setCollisionShape(under ? under : &cube);
		world.addCollisionObject(&upper);
		world.addCollisionObject(&lower);
	}
	~Pair()
	{
		world.removeCollisionObject(&upper);
		world.removeCollisionObject(&lower);
	}
	void look(const btTransform& of)
	{
		upper.setWorldTransform(of);
		look();
	}
	void look()
	{
		world.performDiscreteCollisionDetection();
		registration.store().nextStep();
	}
	const btISTContact* contact() const
	{
		const auto& all = const_cast<btISTRegistration&>(registration).store().contacts();
		return all.empty() ? nullptr : all.front();
	}
	const btISTQueryCost& cost() const { return contact()->cost; }
};

ist::Vec3 forceOf(const btISTContact& c)
{
	return ist::pressureWrench(c.total, {c.constants.k, c.constants.weightA, c.constants.weightB}).force;
}

/// Checks that two contacts are equal to the last bit.
void expectSame(const btISTContact& a, const btISTContact& b)
{
	ASSERT_EQ(a.patchCount, b.patchCount);
	EXPECT_EQ(a.total.pairs, b.total.pairs);
	EXPECT_EQ(a.total.volume, b.total.volume);
	EXPECT_EQ(a.constants.k, b.constants.k);
	for (int i = 0; i < a.patchCount; ++i)
	{
		EXPECT_EQ(distance(a.patches[i].normalA.force, b.patches[i].normalA.force), 0);
		EXPECT_EQ(distance(a.patches[i].normalB.torque, b.patches[i].normalB.torque), 0);
	}
	EXPECT_EQ(distance(a.X_WA.translation, b.X_WA.translation), 0);
	EXPECT_EQ(a.stamp, b.stamp);
}

const btISTContactCache kExact{true, 0}, kAlways{false, 0}, kTolerant{true, 0.05};
}  // namespace

TEST(btISTContactCache, WithoutAGrantedErrorNoSumsThatFollowedTheMotionAreKept)
{
	Pair pair(kTolerant), exact(kAlways);
	const btTransform first = at(vec(.1, .8, .2)), moved = at(vec(.1, .8001, .2));
	pair.look(first);
	pair.look(moved);
	ASSERT_EQ(pair.contact()->use, btISTCachedResult::Moved);
	// The cube returns to the pose of its last query, at a time when results must come from queries.
	ASSERT_FALSE(pair.registration.setContactCache(kExact));
	pair.look(first);
	exact.look(first);
	EXPECT_EQ(pair.contact()->total.volume, exact.contact()->total.volume);
}

TEST(btISTContactCache, StillPairIsQueriedOnce)
{
	for (const btISTContactCache& contactCache : {kExact, kTolerant})
		for (const bool apart : {false, true})
		{
			Pair pair(contactCache);
			for (int i = 0; i < 10; ++i) pair.look(apart ? at(vec(1, 1, 0), vec(0, 0, .7854)) : at(vec(.1, .8, .2)));
			ASSERT_TRUE(pair.contact()) << apart;
			EXPECT_EQ(pair.cost().asked, 1u);
			EXPECT_EQ(pair.cost().cachedStill, 9u);
			EXPECT_EQ(pair.contact()->patchCount == 0, apart);
		}
}

TEST(btISTContactCache, SwitchedOffAsksAlways)
{
	Pair pair(kAlways);
	for (int i = 0; i < 10; ++i) pair.look(at(vec(.1, .8, .2)));
	EXPECT_EQ(pair.cost().asked, 10u);
	EXPECT_EQ(pair.cost().cached(), 0u);

	ASSERT_FALSE(pair.registration.setContactCache(kTolerant));
	for (int i = 0; i < 3; ++i) pair.look();
	ASSERT_EQ(pair.cost().cached(), 2u);
	ASSERT_FALSE(pair.registration.setContactCache(kAlways));
	pair.look();
	EXPECT_EQ(pair.cost().cached(), 2u);
}

// Coarse leaves reach farther than the leaves for which the clearance was computed, and levels change while nothing moves.
TEST(btISTContactCache, AnAcceptedForceErrorIsAnsweredAsWithoutTheCache)
{
	for (const double share : {.1, .3, .6})
	{
		Pair kept(kExact), always(kAlways);
		for (Pair* p : {&kept, &always}) ASSERT_FALSE(p->registration.setForceError(share));
		int touching = 0;
		for (int i = 0; i < 900; ++i)
		{
			// After each 30 steps of motion the cube rests for 60 steps.
			const double way = 1.5 - .002 * (i / 90 * 30 + std::min(i % 90, 30));
			const btTransform place = at(vec(.7071 * way, .7071 * way, .05), vec(0, 0, .7854 + .1 * way));
			for (Pair* p : {&kept, &always}) p->look(place);
			if (!always.contact()) continue;
			ASSERT_TRUE(kept.contact());
			expectSame(*kept.contact(), *always.contact());
			ASSERT_FALSE(HasFailure()) << "error " << share << ", step " << i;
			touching += always.contact()->patchCount > 0;
		}
		EXPECT_GT(touching, 100);
		EXPECT_GT(kept.cost().cachedStill, 100u);
	}
}

TEST(btISTContactCache, TeleportIsSeenWhereverItGoes)
{
	btStaticPlaneShape plane(vec(0, 1, 0), btScalar(.5));
	btCylinderShape cylinder(vec(.5, .5, .5));
	for (btCollisionShape* under :
		{static_cast<btCollisionShape*>(nullptr), static_cast<btCollisionShape*>(&plane), static_cast<btCollisionShape*>(&cylinder)})
	{
		Pair kept(kExact, under), always(kAlways, under);
		std::mt19937 random(1);
		std::uniform_real_distribution<double> u(-1, 1);
		int touching = 0;
		for (int i = 0; i < 120; ++i)
		{
			// In some of the steps both bodies are a kilometre away from the origin.
			const btVector3 far = i % 20 < 3 ? vec(1000, 0, -300) : vec(0, 0, 0);
			const btTransform place = at(
				far + vec(.6 * u(random), 1.1 + .4 * u(random), .6 * u(random)), vec(u(random), u(random), u(random)));
			for (Pair* p : {&kept, &always})
			{
				p->lower.setWorldTransform(at(far));
				p->look(place);
			}
			if (!always.contact()) continue;
			ASSERT_TRUE(kept.contact());
			expectSame(*kept.contact(), *always.contact());
			touching += always.contact()->patchCount > 0;
		}
		EXPECT_GT(touching, 30);
	}
}

TEST(btISTContactCache, ApproachingPairIsQueriedOnlyWhenItMayHaveMet)
{
	btStaticPlaneShape plane(vec(0, 1, 0), btScalar(.15));
	for (btCollisionShape* under : {static_cast<btCollisionShape*>(nullptr), static_cast<btCollisionShape*>(&plane)})
	{
		Pair kept(kExact, under), always(kAlways, under);
		uint64_t apart = 0;
		for (int i = 0; i < 600; ++i)
		{
			// Along the diagonal the bounding boxes meet long before the cubes do.
			const double way = under ? 1.2 - .001 * i : 1.72 - .001 * i;
			const btTransform place = under ? at(vec(.1, way, .05), vec(.05, .0005 * i, .1))
											: at(vec(.7071 * way, .7071 * way, .05), vec(0, 0, .7854 + .0002 * i));
			kept.look(place);
			always.look(place);
			if (!always.contact()) continue;
			expectSame(*kept.contact(), *always.contact());
			apart += always.contact()->patchCount == 0;
		}
		ASSERT_GT(apart, 100u);
		EXPECT_GT(kept.cost().cachedApart, apart / 3);
		EXPECT_GT(always.contact()->patchCount, 0);
	}
}

TEST(btISTContactCache, ClearanceIsUsedUpByTheWayAndNotBefore)
{
	constexpr double kClearance = 0.1, kCorner = 0.866;
	btISTContact contact;
	contact.treeA = contact.treeB = cubeTree();
	const auto useAfter = [&](const ist::Vec3& shift, const ist::Vec3& turn) {
		btISTCachedResult kept;
		contact.X_AB = {ist::rotationMatrix(ist::quaternionFromRotationVector({0.3, 0.2, 0.1})), {3, -2, 5}};
		kept.keep(contact, {}, 0, kClearance, kExact);
		contact.X_AB.rotation = ist::rotationMatrix(ist::quaternionFromRotationVector(turn)) * contact.X_AB.rotation;
		contact.X_AB.translation += shift;
		return kept.use(contact, {}, 0, kExact);
	};
	EXPECT_EQ(useAfter({-0.99 * kClearance, 0, 0}, {}), btISTCachedResult::Apart);
	EXPECT_EQ(useAfter({0, 1.01 * kClearance, 0}, {}), btISTCachedResult::Ask);
	EXPECT_EQ(useAfter({}, {0.3 * kClearance / kCorner, 0, 0}), btISTCachedResult::Apart);
	EXPECT_EQ(useAfter({}, {0, kClearance / kCorner, 0}), btISTCachedResult::Ask);
	EXPECT_EQ(useAfter({0, 0, 0.8 * kClearance}, {0, 0.4 * kClearance / kCorner, 0}), btISTCachedResult::Ask);
}

TEST(btISTContactCache, PressedAndSlidThePairStaysWithinTheErrorBound)
{
	btStaticPlaneShape plane(vec(0, 1, 0), btScalar(.5));
	for (btCollisionShape* under : {static_cast<btCollisionShape*>(nullptr), static_cast<btCollisionShape*>(&plane)})
	{
		Pair kept(kTolerant, under), always(kAlways, under);
		// A stiffness that follows the area (setStiffnessForArea) is that of the last query.
		for (Pair* pair : {&kept, &always}) pair->registration.store().raiseStiffness(true);
		int compared = 0;
		ist::Vec3 asked;
		double off = 0, offIfItStood = 0;
		for (int i = 0; i < 600; ++i)
		{
			const double t = i / 600.0;
			const btTransform place = at(
				vec(.1 * t, .9 - .02 * std::sin(9 * t), .05 * std::cos(5 * t)), vec(.3 + .03 * t, .02 * std::sin(4 * t), .04 * t));
			kept.look(place);
			always.look(place);
			const ist::Vec3 truth = forceOf(*always.contact());
			EXPECT_LE(
				distance(forceOf(*kept.contact()), truth), 0.05 * std::max(norm(truth), btISTCachedResult::floorForce(*always.contact())))
				<< i;
			if (kept.contact()->use == btISTCachedResult::Ask) asked = forceOf(*kept.contact());
			else
			{
				++compared;
				off += distance(forceOf(*kept.contact()), truth);
				offIfItStood += distance(asked, truth);
			}
			// No cached result may have changed by more than half of the accepted error.
			EXPECT_LE(distance(forceOf(*kept.contact()), asked),
				0.5 * 0.0501 * std::max(norm(forceOf(*kept.contact())), btISTCachedResult::floorForce(*kept.contact())))
				<< i;
		}
		EXPECT_GT(compared, 450);
		EXPECT_LT(off, 0.5 * offIfItStood) << "what is kept follows the motion";
		EXPECT_EQ(kept.cost().asked + kept.cost().cached(), 600u);
		EXPECT_LE(kept.cost().largestCacheError, 0.05);
	}
}

TEST(btISTContactCache, CostThatIsResetForgetsTheLargestErrorOfPairsThatGoOn)
{
	Pair pair(kTolerant);
	for (int i = 0; i < 200; ++i) pair.look(at(vec(1e-3 * i, .9 - 1e-4 * i, 0), vec(.2, 0, .1)));
	btISTContactStore& store = pair.registration.store();
	const double before = store.cost().largestCacheError;
	ASSERT_GT(before, 0);
	store.resetCost();
	for (int i = 0; i < 3; ++i) pair.look();
	EXPECT_EQ(store.cost().largestCacheError, 0);
	EXPECT_EQ(pair.cost().largestCacheError, before) << "the pair's own cost is since it began";
}

TEST(btISTContactCache, ScalingOfAClosedFormIsSeenWhileItStandsStill)
{
	btBoxShape box(vec(.5, .5, .5));
	Pair pair(kTolerant, &box);
	pair.look(at(vec(0, .9, 0)));
	pair.look(at(vec(0, .9, 0)));
	EXPECT_EQ(pair.cost().asked, 1u);
	box.setLocalScaling(vec(1, 1.1, 1));
	pair.look();
	EXPECT_EQ(pair.cost().asked, 2u);
	EXPECT_NEAR(pair.contact()->total.volume, .15, .01);
}

TEST(btISTContactCache, ScaledTreeIsBulletsAndIsAskedWhenItComesBack)
{
	Pair pair(kTolerant);
	pair.look(at(vec(0, .9, 0)));
	pair.cube.setLocalScaling(vec(1, 1.1, 1));
	pair.look();
	pair.cube.setLocalScaling(vec(1, 1, 1));
	pair.look();
	EXPECT_EQ(pair.cost().asked, 2u);
	EXPECT_NEAR(pair.contact()->total.volume, .1, .01);
}

TEST(btISTContactCache, PairThatWasNotWatchedIsAskedAgain)
{
	Pair pair(kTolerant);
	pair.look(at(vec(0, .9, 0)));
	btCollisionObject other;
	pair.registration.pairFilter().addPair(&pair.upper, &other);
	pair.look();
	EXPECT_EQ(pair.contact()->patchCount, 0);
	pair.registration.pairFilter().acceptAllPairs();
	pair.look();
	EXPECT_EQ(pair.cost().asked, 2u);
	EXPECT_GT(pair.contact()->patchCount, 0);
}

TEST(btISTContactCache, OtherOptionsOfTheQueryAreSeenWhileNothingMoves)
{
	Pair pair(kTolerant, nullptr, leafTree());
	pair.look(at(vec(0, 1.001, 0)));
	const bool touched = pair.contact()->patchCount > 0;
	pair.registration.requireInnerOverlap(true);
	pair.look();
	EXPECT_EQ(pair.cost().asked, 2u);
	EXPECT_TRUE(touched);
	EXPECT_EQ(pair.contact()->total.volume, 0);
}

/// A rule with chosen k and weights.
struct SetRule : btISTPairRule
{
	btISTPairConstants constants;
	btISTPairConstants decide(const btISTContact&, const btCollisionObject*, const btCollisionObject*) const override { return constants; }
};

TEST(btISTContactCache, ChangedMaterialCountsAtOnceInWhatIsKept)
{
	auto rule = std::make_shared<SetRule>();
	Pair kept(kTolerant), always(kAlways);
	for (Pair* p : {&kept, &always}) p->registration.setPairRule(rule);
	int moved = 0;
	for (int i = 0; i < 60; ++i)
	{
		rule->constants.k = 1000 * (1 + i % 7);
		rule->constants.weightA = (i % 5) / 4.0;
		rule->constants.weightB = 1 - rule->constants.weightA;
		for (Pair* p : {&kept, &always}) p->look(at(vec(0, .9 - 2e-5 * i, 0), vec(.2, 1e-5 * i, 0)));
		EXPECT_EQ(kept.contact()->constants.k, rule->constants.k);
		const ist::Vec3 truth = forceOf(*always.contact());
		EXPECT_LE(
			distance(forceOf(*kept.contact()), truth), 0.05 * std::max(norm(truth), btISTCachedResult::floorForce(*always.contact())));
		moved += kept.contact()->use == btISTCachedResult::Moved;
	}
	EXPECT_GT(moved, 50);
}

TEST(btISTContactCache, ChangedWeightsChooseTheLevelAnewWhileNothingMoves)
{
	const auto settled = [](const std::vector<double>& weightsOfA) {
		auto rule = std::make_shared<SetRule>();
		Pair pair(kTolerant);
		EXPECT_FALSE(pair.registration.setForceError(0.3));
		pair.registration.setPairRule(rule);
		pair.upper.setWorldTransform(at(vec(.75, .8, .3), vec(.3, .5, .2)));
		for (const double weight : weightsOfA)
		{
			rule->constants.weightA = weight;
			rule->constants.weightB = 1 - weight;
			for (int i = 0; i < 300; ++i) pair.look();
		}
		EXPECT_LT(pair.cost().asked, 300 * weightsOfA.size());
		return pair.contact()->accuracy;
	};
	const ist::AdaptiveLevel soft = settled({1}), hard = settled({0}), changed = settled({1, 0});
	ASSERT_NE(soft.errorBound, hard.errorBound);
	EXPECT_EQ(changed.errorBound, hard.errorBound);
	EXPECT_EQ(changed.level, hard.level);
}

TEST(btISTContactCache, CoarseWhereTheHandIsNot)
{
	const auto look = [](std::optional<double> general, std::optional<double> ofUpper, std::optional<double> ofLower) {
		Pair pair(kTolerant, nullptr, leafTree());
		EXPECT_FALSE(pair.registration.setForceError(general.value_or(0)));
		EXPECT_FALSE(pair.registration.setForceErrorOf(&pair.upper, ofUpper));
		EXPECT_FALSE(pair.registration.setForceErrorOf(&pair.lower, ofLower));
		for (int i = 0; i < 300; ++i) pair.look(at(vec(.05, .8, .02), vec(.03, .02, .01)));
		return *pair.contact();
	};
	const btISTContact coarse = look(0.5, {}, {}), leaves = look({}, {}, {});
	ASSERT_GT(coarse.level, 0);
	ASSERT_LT(coarse.total.pairs, leaves.total.pairs / 2);
	EXPECT_EQ(look(0.5, 0.0, {}).total.pairs, leaves.total.pairs) << "of the hand's body the leaves";
	EXPECT_EQ(look({}, {}, 0.5).total.pairs, coarse.total.pairs) << "of one body alone";
	EXPECT_EQ(look(0.5, 0.02, 0.9).total.pairs, look(0.02, {}, {}).total.pairs) << "the smaller of two";

	Pair pair(kTolerant, nullptr, leafTree());
	EXPECT_TRUE(pair.registration.setForceErrorOf(&pair.upper, 1.1));
	EXPECT_TRUE(pair.registration.setForceErrorOf(&pair.upper, -0.1));
	EXPECT_FALSE(pair.registration.setForceErrorOf(&pair.upper, 0.5));
	for (int i = 0; i < 300; ++i) pair.look(at(vec(.05, .8, .02), vec(.03, .02, .01)));
	EXPECT_EQ(pair.contact()->total.pairs, coarse.total.pairs);
	EXPECT_FALSE(pair.registration.setForceErrorOf(&pair.upper, std::nullopt));
	for (int i = 0; i < 300; ++i) pair.look();
	EXPECT_EQ(pair.contact()->total.pairs, leaves.total.pairs) << "taken out while nothing moved";
}

// The damping of a cached result is valid only for its weights. With other weights the pair is queried again, even if nothing moves.
TEST(btISTContactCache, DampingIsThatOfTheWeightsThatThePairHasNow)
{
	for (const btISTContactCache& contactCache : {kExact, kTolerant, kAlways})
	{
		auto rule = std::make_shared<SetRule>();
		Pair pair(contactCache);
		pair.registration.setPairRule(rule);
		const auto expectDamping = [&](double weightA, double dissipation) {
			rule->constants.weightA = weightA;
			rule->constants.weightB = 1 - weightA;
			rule->constants.dissipation = dissipation;
			pair.look(at(vec(.1, .8, .2)));
			const btISTContact& c = *pair.contact();
			ist::QueryOptions options;
			options.damping = {weightA, 1 - weightA};
			ist::QueryWorkspace workspace;
			const auto exact = ist::queryOverlap(*cubeTree(), *cubeTree(), c.X_AB, workspace, options).total.damping;
			ist::OverlapIntegrals sum;
			for (int i = 0; i < c.patchCount; ++i) sum.add(c.patches[i]);
			for (const ist::OverlapIntegrals& o : {c.total, sum})
				for (int i = 0; i < 21; ++i) EXPECT_NEAR(o.damping.m[i], exact.m[i], 1e-5 * c.total.volume) << weightA;
		};
		pair.look(at(vec(.1, .8, .2)));
		EXPECT_EQ(pair.contact()->total.damping(0, 0), 0) << "nobody wants it";
		pair.registration.store().sumDamping(true);
		for (const double weightA : {0.5, 0.0, 0.0, 0.25, 1.0}) expectDamping(weightA, 5);
		const auto asked = pair.cost().asked;
		expectDamping(1, 3);
		EXPECT_EQ(pair.cost().asked, asked + (contactCache.on ? 0 : 1));
	}
}

TEST(btISTContactCache, SleepersAreNotAskedAndWokenOnesAreWhereTheyAre)
{
	for (const bool teleported : {false, true})
	{
		Pair pair(kTolerant);
		pair.look(at(vec(0, .9, 0)));
		for (btCollisionObject* o : {&pair.upper, &pair.lower}) o->forceActivationState(ISLAND_SLEEPING);
		for (int i = 0; i < 5; ++i) pair.look();
		EXPECT_EQ(pair.cost().asked + pair.cost().cached(), 1u);
		if (teleported) pair.upper.setWorldTransform(at(vec(.2, .8, 0)));
		pair.upper.forceActivationState(ACTIVE_TAG);
		pair.look();
		EXPECT_EQ(pair.cost().asked, teleported ? 2u : 1u);
		EXPECT_NEAR(pair.contact()->total.volume, teleported ? .8 * .2 : .1, .01);
		EXPECT_EQ(pair.contact()->stamp + 1, pair.registration.store().step());
	}
}

TEST(btISTContactCache, BodyThatIsRemovedAndPutBackBeginsAnew)
{
	Pair pair(kTolerant);
	pair.look(at(vec(0, .9, 0)));
	pair.look();
	pair.world.removeCollisionObject(&pair.upper);
	EXPECT_EQ(pair.contact(), nullptr);
	pair.world.addCollisionObject(&pair.upper);
	pair.look();
	EXPECT_EQ(pair.cost().asked, 1u);
	EXPECT_EQ(pair.cost().cached(), 0u);
	EXPECT_EQ(pair.registration.store().cost().asked, 2u);
}

TEST(btISTContactCache, NothingIsKeptOverAPoseThatIsNoRigidBodys)
{
	Pair pair(kTolerant);
	pair.look(at(vec(0, .9, 0)));
	btTransform skewed = at(vec(0, .9, 0));
	skewed.getBasis()[0][0] = 2;
	pair.look(skewed);
	EXPECT_EQ(pair.contact()->patchCount, 0);
	EXPECT_EQ(pair.contact()->total.volume, 0);
	pair.look(at(vec(0, .9, 0)));
	EXPECT_EQ(pair.contact()->use, btISTCachedResult::Ask);
	EXPECT_NEAR(pair.contact()->total.volume, .1, .01);
}

TEST(btISTContactCache, ErrorsThatAreNoneAreRefusedAndNothingChanges)
{
	Pair pair(kTolerant);
	for (const double error : {-0.01, 0.51, std::nan("")})
	{
		const auto refused = pair.registration.setContactCache({true, error});
		ASSERT_TRUE(refused) << error;
		EXPECT_NE(refused->message.find("0.5"), std::string::npos);
		EXPECT_EQ(pair.registration.contactCache().maxError, 0.05);
	}
}

TEST(btISTContactCache, TakingBackTheErrorAsksAgainWhatHadMoved)
{
	Pair kept(kTolerant), always(kAlways);
	kept.look(at(vec(0, .9, 0)));
	kept.look(at(vec(0, .8999, 0)));
	EXPECT_EQ(kept.contact()->use, btISTCachedResult::Moved);
	EXPECT_FALSE(kept.registration.setContactCache(kExact));
	kept.look();
	for (int i = 0; i < 3; ++i) always.look(at(vec(0, .8999, 0)));
	EXPECT_EQ(kept.contact()->use, btISTCachedResult::Ask);
	expectSame(*kept.contact(), *always.contact());
}
