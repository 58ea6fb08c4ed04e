// SPDX-License-Identifier: Zlib
// Every pair of features of a world that can be switched between steps, against each other. A new feature is one entry of `features`.
#include "BulletHapticForce/Law/btEnergyLaw.h"
#include "BulletHapticForce/Law/btPaperLaw.h"
#include "BulletHapticForce/World/btISTSceneReport.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/HapticForce/World/FeaturePairsScene.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

using namespace feature_pairs;

namespace
{
/// By how much a feature may change what a world does.
struct Effect
{
	bool exact = false;      ///< by nothing: the world moves bit for bit as without
	double sums = 0;         ///< the force of two trees, as a share of what their leaves have
	double height = 0;       ///< where a body stands [m]
	double energy = 0;       ///< that the switch puts in [J]
	bool allocates = false;  ///< in each step
	bool unsettled = false;  ///< bodies swing
};

/// Another model or another surface carries a body, and it drops by the roughness of the trees.
constexpr Effect kOtherSurface{false, 0, 0.06, 2};

struct Feature
{
	const char* name;
	Effect effect;
	std::function<void(Scene&)> on, off;
};

void refusedIn(const std::optional<ist::Error>& error)
{
	if (error) ADD_FAILURE() << error->message;
}

void setGravity(Scene& s, double g)
{
	refusedIn(s.world.setGravity(btVector3(0, btScalar(-g), 0)));
	for (const auto& body : s.bodies)  // Bullet leaves out those that sleep
		if (!body->isStaticOrKinematicObject()) body->setGravity(btVector3(0, btScalar(-g), 0));
}

void setLaw(Scene& s, bool on)
{
	s.law.reset();
	s.eachStep.erase("law");
	if (on)
	{
		s.law = std::make_unique<btEnergyLaw>();
		refusedIn(s.law->add(&s.body(Lower), plainTree(), &s.body(Upper), levelledTree(), {1e4, 0.5, 0.5}));
		s.eachStep["law"] = [&s] {
			if (s.body(Upper).isInWorld()) s.law->apply();
		};
	}
	for (const Name name : {Lower, Upper}) s.cleanBody(name);
}

void setPaperLaw(Scene& s, bool on)
{
	s.paperLaw.reset();
	s.eachStep.erase("the paper's law");
	if (on)
	{
		s.paperLaw = std::make_unique<btPaperLaw>();
		refusedIn(s.paperLaw->add(&s.body(Table), levelledTree(), &s.body(Lower), plainTree(), {1e5, 30}));
		s.eachStep["the paper's law"] = [&s] { s.paperLaw->apply(kStep); };
	}
	s.cleanBody(Lower);
}

void setKinematic(btRigidBody& body, bool on)
{
	const int flag = btCollisionObject::CF_KINEMATIC_OBJECT, flags = body.getCollisionFlags();
	body.setCollisionFlags(on ? flags | flag : flags & ~flag);
	body.setLinearVelocity(btVector3(0, 0, 0));
	body.setAngularVelocity(btVector3(0, 0, 0));
}

struct Touches : btCollisionWorld::ContactResultCallback
{
	btScalar addSingleResult(
		btManifoldPoint&, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int) override
	{
		return 0;
	}
};

const std::vector<btTransform>& restPoses();

/// Puts `Upper` where it rests, moved by `way` and without a rotation.
void moveUpper(Scene& s, const btVector3& way)
{
	btTransform pose = restPoses()[Upper];
	pose.setOrigin(pose.getOrigin() + way);
	s.place(Upper, pose);
}

const std::vector<Feature>& features()
{
	const auto registration = [](auto function) { return [function](Scene& s) { refusedIn(function(s.world.registration())); }; };
	using R = btISTRegistration;
	static const std::vector<Feature> all = {
		{"the gate", {false, 1, 0.1, 3}, registration([](R& r) { return r.requireInnerOverlap(true); }),
			registration([](R& r) { return r.requireInnerOverlap(false); })},
		{"a force error", {false, 2 * kAccepted, 2e-3, 0.02},
			[](Scene& s) { s.accepted = kAccepted, refusedIn(s.world.setForceError(kAccepted)); },
			[](Scene& s) { s.accepted = 0, refusedIn(s.world.setForceError(0)); }},
		{"a force error of one body", {false, 2 * kAcceptedOfUpper, 2e-3, 0.02},
			[](Scene& s) {
				s.acceptedOfUpper = kAcceptedOfUpper;
				refusedIn(s.world.setForceErrorOf(&s.body(Upper), kAcceptedOfUpper));
			},
			[](Scene& s) { s.acceptedOfUpper = -1, refusedIn(s.world.setForceErrorOf(&s.body(Upper), std::nullopt)); }},
		// Balls of coarse levels press before surfaces touch.
		{"a budget of pairs", {false, 10, 0.06, 1}, registration([](R& r) { return r.setPairBudget(200); }),
			registration([](R& r) { return r.setPairBudget(-1); })},
		{"no economy", {true}, registration([](R& r) {
			 return r.setContactCache({false, 0});
		 }),
			registration([](R& r) {
				return r.setContactCache({true, 0});
			})},
		{"an economy that is wrong by a share", {false, 2 * kKept, 1e-3}, registration([](R& r) {
			 return r.setContactCache({true, kKept});
		 }),
			registration([](R& r) {
				return r.setContactCache({true, 0});
			})},
		{"threads for queries", {true, 0, 0, 0, true}, registration([](R& r) { return r.setQueryThreads(2); }),
			registration([](R& r) { return r.setQueryThreads(1); })},
		{"memories of pairs", {false, 1e-4, 1e-4}, registration([](R& r) { return r.setVerletLists(8); }),
			registration([](R& r) { return r.setVerletLists(0); })},
		{"pairs that are made anew", {false, 0, 1e-3, 0.01}, &Scene::clean, &Scene::clean},
		{"no pair cache", {true}, [](Scene& s) { s.setPairCache(nullptr); },
			[](Scene& s) { s.setPairCache(s.world.bullet().getPairCache()); }},
		{"one watched pair", kOtherSurface,
			[](Scene& s) { s.onlyPair = true, s.world.pairFilter().addPair(&s.body(Lower), &s.body(Table)); },
			[](Scene& s) { s.onlyPair = false, s.world.pairFilter().acceptAllPairs(); }},
		{"a watched region", kOtherSurface,
			[](Scene& s) {
				s.onlyRegion = true;
				refusedIn(s.world.pairFilter().setRegion(kBase - btVector3(2, 10, 5), kBase + btVector3(2, 10, 5)));
			},
			[](Scene& s) { s.onlyRegion = false, s.world.pairFilter().clearRegion(); }},
		{"a material", kOtherSurface,
			[](Scene& s) {
				refusedIn(s.world.materials().set(&s.body(Lower), {5e4, 10}));
			},
			[](Scene& s) { s.world.materials().remove(&s.body(Lower)); }},
		{"less gravity", kOtherSurface, [](Scene& s) { setGravity(s, 5); }, [](Scene& s) { setGravity(s, 9.81); }},
		{"parts of steps", {true}, [](Scene& s) { s.world.setMostSubsteps(4); }, [](Scene& s) { s.world.setMostSubsteps(1); }},
		{"a tree that is detached", kOtherSurface, [](Scene& s) { s.detachLower(), s.cleanIfNothingDoes(); },
			[](Scene& s) { s.attachLower(std::make_shared<const ist::InnerSphereTree>(*plainTree())), s.cleanIfNothingDoes(); }},
		{"another tree", kOtherSurface, [](Scene& s) { s.detachLower(), s.attachLower(coarseTree()); },
			[](Scene& s) { s.detachLower(), s.attachLower(std::make_shared<const ist::InnerSphereTree>(*plainTree())); }},
		{"another shape", kOtherSurface, [](Scene& s) { s.body(Upper).setCollisionShape(&s.ballShape); },
			[](Scene& s) {
				s.body(Upper).setCollisionShape(&s.upperShape);
				s.cleanBody(Upper);  // pairs that it began with the other shape stay that shape's, as Bullet has it
			}},
		{"a scaled shape", kOtherSurface, [](Scene& s) { s.upperShape.setLocalScaling(btVector3(1, btScalar(1.004), 1)); },
			[](Scene& s) { s.upperShape.setLocalScaling(btVector3(1, 1, 1)); }},
		{"a body that is moved", kOtherSurface, [](Scene& s) { moveUpper(s, btVector3(btScalar(0.1), 0, btScalar(-0.07))); },
			[](Scene& s) { moveUpper(s, btVector3(0, 0, 0)); }},
		{"a body that is removed", kOtherSurface, [](Scene& s) { s.world.bullet().removeRigidBody(&s.body(Upper)); },
			[](Scene& s) {
				s.place(Upper, restPoses()[Upper]);
				s.addUpper();
			}},
		{"a body that is added", {false, 0, 0, 0.05}, [](Scene& s) { s.world.bullet().addRigidBody(&s.body(Extra)); },
			[](Scene& s) {
				s.world.bullet().removeRigidBody(&s.body(Extra));
				s.place(Extra, restPoses()[Extra]);
			}},
		{"foreign entries in the tables", {true},
			[](Scene& s) {
				btGImpactCollisionAlgorithm::registerAlgorithm(static_cast<btCollisionDispatcher*>(s.world.bullet().getDispatcher()));
			},
			registration([](R& r) { return r.reinstall(); })},
		{"resident memory", {true}, registration([](R& r) { return r.makeResident(); }), [](Scene&) {}},
		{"the energy law", {false, 0, 0.04, 1, false, true}, [](Scene& s) { setLaw(s, true); }, [](Scene& s) { setLaw(s, false); }},
		{"few iterations", {false, 0, 2e-3, 0.02}, [](Scene& s) { s.world.bullet().getSolverInfo().m_numIterations = 4; },
			[](Scene& s) { s.world.bullet().getSolverInfo().m_numIterations = 10; }},
		{"a random order of rows", {false, 0, 1e-3, 0.01},
			[](Scene& s) { s.world.bullet().getSolverInfo().m_solverMode |= SOLVER_RANDMIZE_ORDER; },
			[](Scene& s) { s.world.bullet().getSolverInfo().m_solverMode &= ~SOLVER_RANDMIZE_ORDER; }},
		{"sleep", kOtherSurface,
			[](Scene& s) {
				for (const Name name : {Lower, Upper}) s.place(name, s.body(name).getWorldTransform());
				for (const Name name : {Lower, Upper}) s.body(name).forceActivationState(ISLAND_SLEEPING);
			},
			[](Scene& s) {
				for (const Name name : {Lower, Upper}) s.body(name).forceActivationState(DISABLE_DEACTIVATION);
			}},
		{"a kinematic body", kOtherSurface, [](Scene& s) { setKinematic(s.body(Upper), true); },
			[](Scene& s) { setKinematic(s.body(Upper), false); }},
		{"contact tests", {true},
			[](Scene& s) {
				s.eachStep["contact tests"] = [&s] {
					Touches touches;
					s.world.bullet().contactTest(&s.body(Lower), touches);
					s.world.bullet().contactPairTest(&s.body(Upper), &s.body(OnBox), touches);
				};
			},
			[](Scene& s) { s.eachStep.erase("contact tests"); }},
		{"reports", {true}, [](Scene& s) { s.eachStep["reports"] = [&s] { (void)btISTSceneReport::of(s.world).json(); }; },
			[](Scene& s) { s.eachStep.erase("reports"); }},
		{"leaves for one body", {true}, [](Scene& s) { refusedIn(s.world.setForceErrorOf(&s.body(OnBox), 0.0)); },
			[](Scene& s) { refusedIn(s.world.setForceErrorOf(&s.body(OnBox), std::nullopt)); }},
		{"the paper's law", {false, 0, 0.06, 1.5, false, true}, [](Scene& s) { setPaperLaw(s, true); },
			[](Scene& s) { setPaperLaw(s, false); }},
		{"measured queries", {true}, [](Scene& s) { s.world.contacts().measureQueryTime(true); },
			[](Scene& s) { s.world.contacts().measureQueryTime(false); }},
	};
	return all;
}

/// Bodies begin at rest, and no contact remembers anything.
void restart(Scene& s)
{
	for (int i = 0; i < Bodies; ++i)
		if (!s.body(i).isStaticObject()) s.place(i, restPoses()[size_t(i)]);
	s.clean();
}

/// Where the bodies of a scene without features come to rest.
const std::vector<btTransform>& restPoses()
{
	static const std::vector<btTransform> poses = [] {
		Scene s;
		s.world.bullet().addRigidBody(&s.body(Extra));
		s.run(600);
		std::vector<btTransform> all;
		for (const auto& body : s.bodies) all.push_back(body->getWorldTransform());
		return all;
	}();
	return poses;
}

using State = std::vector<btScalar>;
constexpr size_t kLast = 3;                // phase of a pair
constexpr int kNumbers = 18, kHeight = 6;  // of a body in a state, and where its height stands

State stateOf(Scene& s)
{
	State state;
	for (int i = 0; i < Extra; ++i)
		for (int k = 0; k < 3; ++k)
		{
			state.push_back(s.body(i).getWorldTransform().getOrigin()[k]);
			state.push_back(s.body(i).getLinearVelocity()[k]);
			state.push_back(s.body(i).getAngularVelocity()[k]);
			for (int j = 0; j < 3; ++j) state.push_back(s.body(i).getWorldTransform().getBasis()[k][j]);
		}
	return state;
}

double farthest(const State& a, const State& b)
{
	double most = 0;
	for (size_t i = 0; i < a.size(); ++i)
	{
		const double way = std::fabs(double(a[i]) - double(b[i]));
		if (!(way <= most)) most = way;
	}
	return most;
}

/// After each phase of a world without features, and after it was begun anew.
const std::vector<State>& plainStates()
{
	static const std::vector<State> all = [] {
		std::vector<State> states;
		Scene s;
		restart(s);
		for (const int steps : {kOn, kBoth, kOne, kOff}) s.run(steps), states.push_back(stateOf(s));
		restart(s);
		s.run(kFresh);
		states.push_back(stateOf(s));
		return states;
	}();
	return all;
}
double plainHeight(size_t phase, int name)
{
	return name == Extra ? double(restPoses()[Extra].getOrigin().y()) : double(plainStates()[phase][size_t(kNumbers * name + kHeight)]);
}

/// What may be said of the world while these are on, or were a moment ago.
Effect together(const Effect& a, const Effect& b)
{
	return {a.exact && b.exact, a.sums + b.sums, a.height + b.height, a.energy + b.energy, a.allocates || b.allocates,
		a.unsettled || b.unsettled};
}

bool speaks(const Scene& s, int name)
{
	const btCollisionShape* shape = s.bodies[size_t(name)]->getCollisionShape();
	if (shape == &s.lowerShape) return s.lower.isAttached();
	if (shape == &s.upperShape) return s.upperShape.getLocalScaling() == btVector3(1, 1, 1);
	return shape == &s.tableShape;
}

/// Bullet's boxes, planes and balls are known in closed form, unless a tree that does not speak for them is attached.
bool isKnown(const Scene& s, int name) { return speaks(s, name) || s.bodies[size_t(name)]->getCollisionShape() != &s.upperShape; }

bool isWatched(const Scene& s, int a, int b)
{
	if (s.onlyPair && !(std::min(a, b) == Table && std::max(a, b) == Lower)) return false;
	const auto inside = [&](int name) {
		return name == Plane || std::fabs(double(s.bodies[size_t(name)]->getWorldTransform().getOrigin().x() - kBase.x())) < 3;
	};
	return !s.onlyRegion || (inside(a) && inside(b));
}

btISTPairReport::Model modelOf(const Scene& s, int a, int b)
{
	const bool trees = speaks(s, a) && speaks(s, b);
	if ((!speaks(s, a) && !speaks(s, b)) || !isKnown(s, a) || !isKnown(s, b) || !isWatched(s, a, b)) return btISTPairReport::Stock;
	if (trees) return btISTPairReport::Trees;
	return a == Plane || b == Plane ? btISTPairReport::HalfSpace : btISTPairReport::ClosedForm;
}

void expectRightReport(Scene& s)
{
	const btISTSceneReport report = btISTSceneReport::of(s.world);
	EXPECT_EQ(int(report.pairs.size()), s.world.bullet().getPairCache()->getNumOverlappingPairs());
	EXPECT_LE(s.world.contacts().contacts().size(), report.pairs.size());
	for (const btISTPairReport& pair : report.pairs)
	{
		const int a = s.nameOf(pair.bodyA), b = s.nameOf(pair.bodyB);
		ASSERT_TRUE(a >= 0 && b >= 0);
		if (!pair.bodyA->isActive() && !pair.bodyB->isActive()) continue;
		const int first = std::min(a, b), second = std::max(a, b);
		const bool held = (s.law && first == Lower && second == Upper) || (s.paperLaw && first == Table && second == Lower);
		EXPECT_EQ(pair.model, held ? btISTPairReport::None : modelOf(s, a, b)) << a << " and " << b << ": " << pair.reason;
		if (pair.model != btISTPairReport::Trees) continue;
		const bool upper = a == Upper || b == Upper;
		EXPECT_EQ(pair.acceptedError, upper && s.acceptedOfUpper >= 0 ? s.acceptedOfUpper : s.accepted) << a << " and " << b;
	}
}

/// Against queries of their own, of all leaves.
void expectRightSums(Scene& s, double share)
{
	static ist::QueryWorkspace workspace;
	for (const btISTContact* contact : s.world.contacts().contacts())
	{
		if (!contact->treeA || !contact->treeB || contact->stamp + 1 != s.world.contacts().step()) continue;
		if (contact->accuracy.fadedShare > 0) continue;  // a level fades out over hundreds of steps
		const ist::OverlapResult leaves = ist::queryOverlap(*contact->treeA, *contact->treeB, contact->X_AB, workspace);
		const ist::PressurePair law{1, contact->constants.weightA, contact->constants.weightB};
		const ist::Vec3 truth = ist::pressureWrench(leaves.total, law).force, force = ist::pressureWrench(contact->total, law).force;
		const double scale = std::max(norm(truth), ist::forceFloor(contact->treeA->volume, contact->treeB->volume));
		EXPECT_LE(norm(force - truth), (share + 1e-5) * scale) << s.nameOf(contact->bodyA) << " and " << s.nameOf(contact->bodyB);
	}
}

/// Each body stands where it stood, and what carries it gives it its weight.
void expectAtRest(Scene& s, const Effect& effect, size_t phase)
{
	for (int i = 0; i < Bodies; ++i)
	{
		if (!s.moves(i)) continue;
		const btRigidBody& body = s.body(i);
		EXPECT_NEAR(s.height(i), plainHeight(phase, i), 2e-4 + effect.height) << i;
		const double weight = -kMass * double(body.getGravity().y()) * kMeasured * kStep,
					 gained = kMass * (double(body.getLinearVelocity().y()) - s.speedBefore[size_t(i)]);
		EXPECT_NEAR(s.upward[size_t(i)], weight + gained, 0.02 * weight) << i;
		// What is deep in another body leaves it by up to 0.2 m/s, the inverse of the dissipation.
		const bool leaves = phase < kLast ? effect.energy > 0.1 : effect.height > 0.1;
		const double slow = effect.unsettled ? 1 : leaves ? 0.3 : 0.15;
		EXPECT_LT(double(body.getLinearVelocity().length()), slow) << i;
	}
	EXPECT_LE(s.kinetic, 0.02 + effect.energy);
}

void check(Scene& s, const Effect& effect, size_t phase)
{
	if (effect.exact)
	{
		EXPECT_EQ(farthest(stateOf(s), plainStates()[phase]), 0);
	}
	if (!effect.allocates && effect.energy < 0.1)  // others still land, and find more patches than before
	{
		EXPECT_EQ(s.allocations, 0);
	}
	expectAtRest(s, effect, phase);
	expectRightReport(s);
	expectRightSums(s, effect.sums);
}

void tryPair(const Feature& a, const Feature& b)
{
	SCOPED_TRACE(std::string(a.name) + ", then " + b.name);
	const long owners = levelledTree().use_count(), ownersOfCoarse = coarseTree().use_count();
	{
		Scene s;
		restart(s);
		const bool alone = &a == &b;
		const Effect both = alone ? a.effect : together(a.effect, b.effect);
		const size_t contacts = 7;
		a.on(s);
		s.run(kOn);
		if (!alone) b.on(s);
		s.run(kBoth);
		{
			SCOPED_TRACE("both on");
			check(s, both, 1);
		}
		if (!alone) a.off(s);
		s.run(kOne);
		{
			SCOPED_TRACE("the second on");
			check(s, both, 2);
		}
		b.off(s);
		s.run(kOff);
		{
			SCOPED_TRACE("both off");
			Effect none;
			none.exact = both.exact;
			none.energy = both.energy, none.height = both.height;
			check(s, none, 3);
			EXPECT_EQ(s.world.contacts().contacts().size(), contacts);
			EXPECT_TRUE(s.detached.expired());
		}
		restart(s);
		s.run(kFresh);
		SCOPED_TRACE("begun anew");
		// Contacts may be made, and so be solved, in another order.
		EXPECT_LE(farthest(stateOf(s), plainStates()[4]), both.exact ? 0 : 1e-3);
	}
	EXPECT_EQ(levelledTree().use_count(), owners);
	EXPECT_EQ(coarseTree().use_count(), ownersOfCoarse);
}
}  // namespace

class FeaturePairsOfAWorld : public testing::TestWithParam<size_t>
{};

TEST_P(FeaturePairsOfAWorld, Alone) { tryPair(features()[GetParam()], features()[GetParam()]); }

TEST_P(FeaturePairsOfAWorld, GetAlong)
{
	for (const Feature& other : features())
		if (&other != &features()[GetParam()]) tryPair(features()[GetParam()], other);
}

INSTANTIATE_TEST_SUITE_P(All, FeaturePairsOfAWorld, testing::Range(size_t(0), features().size()), [](const auto& info) {
	std::string name = features()[info.param].name;
	for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
	return name;
});
