// SPDX-License-Identifier: Zlib
#include "tests/unit/ISTCollision/Dispatch/AlgorithmWorld.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <LinearMath/btThreads.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <regex>
#include <set>
#include <string>

namespace
{
/// A dispatcher that exposes its tables.
template <class Dispatcher> struct Peek : Dispatcher
{
	using Dispatcher::Dispatcher;
	btCollisionAlgorithmCreateFunc* contacts(int i, int j) { return this->m_doubleDispatchContactPoints[i][j]; }
	btCollisionAlgorithmCreateFunc* closest(int i, int j) { return this->m_doubleDispatchClosestPoints[i][j]; }
};

/// Registers as this library does, and delegates to the function that was registered before.
struct Delegating : btCollisionAlgorithmCreateFunc
{
	btCollisionAlgorithmCreateFunc* found = nullptr;
	int calls = 0;
	btCollisionAlgorithm* CreateCollisionAlgorithm(
		btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b) override
	{
		++calls;
		return found->CreateCollisionAlgorithm(info, a, b);
	}
};
}  // namespace

// The shape is larger than its tree. If one of the tables were not registered, Bullet's own box-box algorithm would answer with a depth
// of 0.3.
TEST(btISTRegistration, AnswersThroughBothDispatchTables)
{
	TestWorld w;
	w.world->setGravity(btVector3(0, 0, 0));
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	EXPECT_TRUE(r.isRegistered());
	btBoxShape box(btVector3(.6, .6, .6));
	const auto keep = attach(r, box);
	btRigidBody* lower = w.add(&box, 1, at(1000, 2, 3));
	btRigidBody* upper = w.add(&box, 1, at(1000, 2.9, 3));

	CollectPoints query;
	w.world->contactPairTest(upper, lower, query);
	EXPECT_GT(query.count, 0);
	EXPECT_GT(std::fabs(double(query.normal.y())), .7) << "near an edge a patch leans by up to the 45 degrees of its cone";
	EXPECT_NEAR(query.deepest, -.1, .06);
	EXPECT_EQ(r.store().contacts().size(), 0u) << "a contact test must not touch the store";

	w.world->performDiscreteCollisionDetection();
	ASSERT_EQ(r.store().contacts().size(), 1u);
	const btISTContact& c = *r.store().contacts()[0];
	EXPECT_EQ(r.store().find(c.manifold), &c);
	EXPECT_EQ(c.bodyA, c.manifold->getBody0());
	EXPECT_NEAR(c.total.volume, .1, .03);
	EXPECT_GT(c.patchCount, 0);
	ASSERT_GT(c.manifold->getNumContacts(), 0);
	const double side = c.bodyA == upper ? 1 : -1;
	double steepest = 0;
	for (int i = 0; i < c.manifold->getNumContacts(); ++i)
	{
		const btManifoldPoint& p = c.manifold->getContactPoint(i);
		steepest = std::max(steepest, side * double(p.m_normalWorldOnB.y()));
		EXPECT_GT(p.getDistance(), -.04);
		EXPECT_TRUE(p.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING);
	}
	EXPECT_GT(steepest, .7) << "the sides of the boxes, which are inside one another, press aside";

	CollectPoints whole;
	w.world->contactTest(upper, whole);
	EXPECT_EQ(whole.count, query.count);
}

TEST(btISTRegistration, EveryEntryButSoftBodiesIsRegisteredAndPutBack)
{
	btDefaultCollisionConfiguration configuration;
	Peek<btCollisionDispatcher> d(&configuration);
	Peek<btCollisionDispatcher> untouched(&configuration);
	{
		const auto r = btISTCollisionAlgorithm::registerAlgorithm(&d);
		const auto second = btISTCollisionAlgorithm::registerAlgorithm(&d);
		EXPECT_TRUE(second.isRegistered());
		for (int i = 0; i < MAX_BROADPHASE_COLLISION_TYPES; ++i)
			for (int j = 0; j < MAX_BROADPHASE_COLLISION_TYPES; ++j)
			{
				const bool soft = i == SOFTBODY_SHAPE_PROXYTYPE || j == SOFTBODY_SHAPE_PROXYTYPE;
				EXPECT_EQ(d.contacts(i, j) == untouched.contacts(i, j), soft);
				EXPECT_EQ(d.closest(i, j) == untouched.closest(i, j), soft);
			}
	}
	for (int i = 0; i < MAX_BROADPHASE_COLLISION_TYPES; ++i)
		for (int j = 0; j < MAX_BROADPHASE_COLLISION_TYPES; ++j)
		{
			EXPECT_EQ(d.contacts(i, j), untouched.contacts(i, j));
			EXPECT_EQ(d.closest(i, j), untouched.closest(i, j));
		}
}

TEST(btISTRegistration, LeavesTheTablesOfADispatcherWithThreadsAlone)
{
	btSetTaskScheduler(btGetSequentialTaskScheduler());
	btDefaultCollisionConfiguration configuration;
	Peek<btCollisionDispatcherMt> d(&configuration);
	Peek<btCollisionDispatcher> untouched(&configuration);
	btBoxShape box(btVector3(.5, .5, .5));
	{
		auto r = btISTCollisionAlgorithm::registerAlgorithm(&d);
		EXPECT_NE(r.refusal().find("threads"), std::string::npos);
		EXPECT_FALSE(r.isRegistered());
		r.reinstall();
		EXPECT_FALSE(r.isRegistered());
		const auto attachment = attach(r, box);  // without a registration this has no effect and does no harm
		for (int i = 0; i < MAX_BROADPHASE_COLLISION_TYPES; ++i)
			for (int j = 0; j < MAX_BROADPHASE_COLLISION_TYPES; ++j)
			{
				EXPECT_EQ(d.contacts(i, j), untouched.contacts(i, j));
				EXPECT_EQ(d.closest(i, j), untouched.closest(i, j));
			}
	}
	btCollisionDispatcher plain(&configuration);
	EXPECT_EQ(btISTCollisionAlgorithm::registerAlgorithm(&plain).refusal(), "");
	btSetTaskScheduler(nullptr);
}

TEST(btISTRegistration, TwoThatDelegateToEachOtherComeToAnEnd)
{
	btDefaultCollisionConfiguration configuration;
	Peek<btCollisionDispatcher> d(&configuration);
	btBoxShape box(btVector3(.5, .5, .5));
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&d);
	const auto keep = attach(r, box);
	constexpr int kBall = SPHERE_SHAPE_PROXYTYPE;
	Delegating other;
	other.found = d.contacts(kBall, kBall);
	d.registerCollisionCreateFunc(kBall, kBall, &other);
	r.reinstall();
	EXPECT_EQ(d.contacts(kBall, kBall), other.found);
	btSphereShape shape(1);
	btCollisionObject a, b;
	a.setCollisionShape(&shape);
	b.setCollisionShape(&shape);
	const btCollisionObjectWrapper wrapA(nullptr, &shape, &a, a.getWorldTransform(), -1, -1),
		wrapB(nullptr, &shape, &b, b.getWorldTransform(), -1, -1);
	btCollisionAlgorithm* algorithm = d.findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
	ASSERT_NE(algorithm, nullptr);
	EXPECT_EQ(other.calls, 1);
	algorithm->~btCollisionAlgorithm();
	d.freeCollisionAlgorithm(algorithm);
}

// The library's create function calls another one for Bullet's own algorithm, and that one delegates back to the library.
TEST(btISTRegistration, AnUnwatchedPairIsBulletsThoughSomeoneDelegatesToUs)
{
	btBoxShape box(btVector3(.5, .5, .5));
	Delegating other;
	constexpr int kBox = BOX_SHAPE_PROXYTYPE;
	btDefaultCollisionConfiguration configuration;
	Peek<btCollisionDispatcher> d(&configuration);
	auto second = btISTCollisionAlgorithm::registerAlgorithm(&d);
	const auto keepHere = attach(second, box);
	other.found = d.contacts(kBox, kBox);
	d.registerCollisionCreateFunc(kBox, kBox, &other);
	second.reinstall();
	btCollisionObject a, b, c;
	for (btCollisionObject* object : {&a, &b, &c}) object->setCollisionShape(&box);
	second.pairFilter().addPair(&a, &c);
	b.setWorldTransform(at(0, .9, 0));
	const btCollisionObjectWrapper wrapA(nullptr, &box, &a, a.getWorldTransform(), -1, -1),
		wrapB(nullptr, &box, &b, b.getWorldTransform(), -1, -1);
	btCollisionAlgorithm* algorithm = d.findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
	btManifoldResult result(&wrapA, &wrapB);
	algorithm->processCollision(&wrapA, &wrapB, btDispatcherInfo(), &result);
	EXPECT_EQ(other.calls, 1);
	btManifoldArray manifolds;
	algorithm->getAllContactManifolds(manifolds);
	int points = 0;
	for (int i = 0; i < manifolds.size(); ++i) points += manifolds[i]->getNumContacts();
	EXPECT_GT(points, 0);
	algorithm->~btCollisionAlgorithm();
	d.freeCollisionAlgorithm(algorithm);
}

TEST(btISTRegistration, NoticesThatSomeoneRegisteredAfterIt)
{
	TestWorld w;
	auto r = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	auto* stock = w.configuration.getCollisionAlgorithmCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE);
	w.dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, stock);
	EXPECT_FALSE(r.isRegistered());
	r.reinstall();
	EXPECT_TRUE(r.isRegistered());
}

TEST(btISTRegistration, ASecondOneWithAnotherRegistryIsRefusedInWordsAndChangesNothing)
{
	TestWorld w;
	btBoxShape box(btVector3(.5, .5, .5));
	const auto shared = std::make_shared<btISTRegistry>(), mine = std::make_shared<btISTRegistry>();
	std::optional<btISTRegistration> first;
	first = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, w.broadphase.getOverlappingPairCache(), shared);
	// A later registration for one pair of types does not hide the first registration.
	auto* stock = w.configuration.getCollisionAlgorithmCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE);
	for (const bool overwritten : {false, true})
	{
		if (overwritten) w.dispatcher.registerCollisionCreateFunc(BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, stock);
		const auto same = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, nullptr, shared);
		EXPECT_EQ(same.refusal(), "");
		auto second = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, nullptr, mine);
		EXPECT_NE(second.refusal().find("another registry"), std::string::npos) << second.refusal();
		EXPECT_FALSE(second.isRegistered());
		EXPECT_TRUE(second.reinstall());
		EXPECT_EQ(&second.registry(), mine.get());
		EXPECT_TRUE(second.setPairRule(std::make_shared<btISTDefaultPairRule>(1))) << "nothing would ask it";
		EXPECT_TRUE(second.setPairBudget(100));
		EXPECT_EQ(&first->registry(), shared.get());
		EXPECT_EQ(first->isRegistered(), !overwritten);
		EXPECT_FALSE(first->reinstall());
	}
	const auto attachment = attach(*first, box);
	w.add(&box, 1, at(0, 0, 0));
	w.add(&box, 1, at(0, .9, 0));
	w.step(1);
	EXPECT_EQ(first->store().contacts().size(), 1u);
	first.reset();
	auto third = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, nullptr, mine);
	EXPECT_EQ(third.refusal(), "");
	EXPECT_TRUE(third.isRegistered());
	third.cleanPairs(w.broadphase.getOverlappingPairCache());
}

TEST(btISTRegistration, NeedsADispatcher)
{
	const auto r = btISTCollisionAlgorithm::registerAlgorithm(nullptr);
	EXPECT_NE(r.refusal().find("no dispatcher"), std::string::npos);
	EXPECT_FALSE(r.isRegistered());
}

TEST(btISTRegistration, OneHandleAtATimeDecidesThePairRule)
{
	TestWorld w;
	const auto rule = std::make_shared<btISTDefaultPairRule>();
	auto second = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
	{
		auto first = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
		EXPECT_FALSE(first.setPairRule(rule));
		EXPECT_FALSE(first.setPairRule(rule)) << "again, by the same handle";
		const auto refused = second.setPairRule(rule);
		ASSERT_TRUE(refused);
		EXPECT_NE(refused->message.find("has set the pair rule"), std::string::npos);
		btISTRegistration moved(std::move(first));
		EXPECT_FALSE(moved.setPairRule(rule));
		EXPECT_TRUE(second.setPairRule(rule));
		EXPECT_TRUE(moved.setPairRule(nullptr));
		moved.release();
		EXPECT_FALSE(second.setPairRule(rule));
	}
	EXPECT_FALSE(second.setPairRule(rule));
}

namespace
{
/// One public function of btISTRegistration and its result without a registration.
struct Use
{
	const char* name;
	std::function<bool(btISTRegistration&)> isSafe;
};

bool isReleased(const std::optional<ist::Error>& error) { return error && error->message.find("this registration was released") == 0; }

/// The shape may be destroyed first and the attachment last, because neither knows a world.
bool takesAttachments(btISTRegistry& registry)
{
	btBoxShape box(btVector3(.5, .5, .5));
	const auto attachment = registry.attach(&box, boxTree());
	return attachment && registry.size() == 1;
}

const Use kUses[] = {
	{"isRegistered", [](auto& r) { return !r.isRegistered(); }},
	{"refusal", [](auto& r) { return r.refusal().find("this registration was released") == 0; }},
	{"reinstall", [](auto& r) { return isReleased(r.reinstall()); }},
	{"makeResident", [](auto& r) { return isReleased(r.makeResident()); }},
	{"release", [](auto& r) { return r.release(), !r.isRegistered(); }},
	{"dispatcherIsGone", [](auto& r) { return r.dispatcherIsGone(), !r.isRegistered(); }},
	{"registry", [](auto& r) { return takesAttachments(r.registry()) && r.registry().size() == 0; }},
	{"store", [](auto& r) { return r.store().contacts().empty() && !r.store().find(nullptr) && r.store().step() > 0; }},
	{"sharedStore", [](auto& r) { return r.sharedStore().get() == &r.store(); }},
	{"pairFilter", [](auto& r) { return r.pairFilter().addPair(nullptr, nullptr), &r.pairFilter() == &r.pairFilter(); }},
	{"setPairRule", [](auto& r) { return isReleased(r.setPairRule(std::make_shared<btISTDefaultPairRule>())); }},
	{"requireInnerOverlap", [](auto& r) { return isReleased(r.requireInnerOverlap(true)); }},
	{"setForceError", [](auto& r) { return isReleased(r.setForceError(0.1)); }},
	{"forceError", [](auto& r) { return r.forceError() == 0; }},
	{"setForceErrorOf", [](auto& r) { return isReleased(r.setForceErrorOf(nullptr, 0.1)); }},
	{"forceErrorOf", [](auto& r) { return r.forceErrorOf(nullptr, nullptr) == 0; }},
	{"setPairBudget", [](auto& r) { return isReleased(r.setPairBudget(500)); }},
	{"pairBudget", [](auto& r) { return r.pairBudget() == -1; }},
	{"setContactCache", [](auto& r) { return isReleased(r.setContactCache({})); }},
	{"contactCache", [](auto& r) { return r.contactCache().maxError == btISTContactCache().maxError; }},
	{"setQueryThreads", [](auto& r) { return isReleased(r.setQueryThreads(2)); }},
	{"queryThreads", [](auto& r) { return r.queryThreads() == 1; }},
	{"sharedQueries", [](auto& r) { return r.sharedQueries().pairs == 0; }},
	{"setVerletLists", [](auto& r) { return isReleased(r.setVerletLists(1)); }},
	{"verletLists", [](auto& r) { return r.verletLists() == 0; }},
	{"setPairCache", [](auto& r) { return isReleased(r.setPairCache(nullptr)); }},
	{"cleanPairs", [](auto& r) { return r.cleanPairs(nullptr), true; }},
};

/// Names of the public functions that the header declares.
std::set<std::string> publicFunctions()
{
	std::ifstream file(HEADER_FOLDER "/btISTRegistration.h");
	const std::string text{std::istreambuf_iterator<char>(file), {}};
	const size_t begin = text.find("class [[nodiscard]] btISTRegistration");
	const std::string declared = text.substr(begin, text.find("// Former names", begin) - begin);
	std::set<std::string> names;
	const std::regex function("\n\t[^/\n]*?[ &](\\w+)\\([^\n]*;");
	for (std::sregex_iterator i(declared.begin(), declared.end(), function), end; i != end; ++i)
		if ((*i)[1] != "btISTRegistration" && (*i)[1] != "operator") names.insert((*i)[1]);
	return names;
}
}  // namespace

TEST(btISTRegistration, EveryFunctionIsSafeWithoutARegistration)
{
	std::set<std::string> tried;
	for (const Use& use : kUses)
	{
		tried.insert(use.name);
		TestWorld w;
		btISTRegistration made;
		EXPECT_TRUE(use.isSafe(made)) << use.name << " of one that was default-made";
		auto released = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, w.broadphase.getOverlappingPairCache());
		released.release();
		EXPECT_TRUE(use.isSafe(released)) << use.name << " of one that was released";
		auto from = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher, w.broadphase.getOverlappingPairCache());
		const btISTRegistration to(std::move(from));
		EXPECT_TRUE(use.isSafe(from)) << use.name << " of one that was moved from";
		EXPECT_TRUE(to.isRegistered());
		btISTRegistration again = std::move(made);
		EXPECT_TRUE(use.isSafe(again)) << use.name << " of a moved one without a registration";
		again = btISTCollisionAlgorithm::registerAlgorithm(&w.dispatcher);
		EXPECT_TRUE(again.isRegistered());
	}
	EXPECT_EQ(tried, publicFunctions());
}
