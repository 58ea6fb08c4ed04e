// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactCache.h"
#include "BulletISTCollision/Core/Accuracy/AdaptiveLevel.h"
#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

class btCollisionObject;
class btCollisionShape;
class btPersistentManifold;
class btISTVerletList;
struct btISTContact;

/// Origin of the stiffness k of a pair.
enum class btISTStiffnessRule
{
	Given,     ///< a material, or a rule of the caller; the solver does not change it
	Fluid,     ///< the density of a fluid and gravity; the solver does not change it
	OwnLoad,   ///< the weight of the heavier of the two bodies
	PileLoad,  ///< the weight of all bodies that are connected with the two through contacts
	Pressed,   ///< the force that has lately pressed on the area of the contact, or the speed at which the bodies approach
	StepBound  ///< the largest stiffness that is stable at this time step (docs/stability.md); the load would need more
};

/// The constants of a pair in the pressure field law (docs/model.md).
struct btISTPairConstants
{
	double k = 1;                         ///< stiffness [Pa/m]
	double weightA = 0.5, weightB = 0.5;  ///< weights of A's and of B's field; their sum is 1
	double load = 0;     ///< force that k carries at the aimed depth [N]; the solver raises it to the weight of a pile; 0: k was given
	double depth = 0;    ///< if k follows from a load: the mean depth (ist::meanDepth) at which the pair shall rest [m]
	double gravity = 0;  ///< if k follows from a load: the larger gravity of the two bodies [m/s^2]
	btISTStiffnessRule rule = btISTStiffnessRule::Given;
	double dissipation = 5;    ///< Hunt-Crossley: the pressure grows by this times the approach speed [s/m]
	bool freeRolling = false;  ///< true: damping does not resist rolling. False: it does, as the law says (docs/model.md, section 2)
};

/// State that the solver keeps for a pair from step to step while it overlaps.
struct btISTContactEnergyTank
{
	static constexpr int kMaxPatches = btISTCachedResult::kMaxPatches;

	bool open = false;                  ///< false until the first solve of an overlap
	double stored = 0;                  ///< elastic work absorbed and not yet returned: what the pair may still give back [J]
	double damped = 0;                  ///< energy that damping took and that a larger stiffness may still store [J]
	bool turned = false;                ///< whether the force has reversed in the last step
	ist::Vec3 direction;                ///< direction of the force on A when it last had one direction, World axes; zero before
	ist::Wrench friction[kMaxPatches];  ///< friction of the last step on A, World axes, about the patch: the solver's next initial guess
										///< [N, N m]
};

/// From where the solver judges whether a stiffness that grows by what presses has an effect. A contact whose overlap stays as it was is
/// clamped: it presses as much as k says.
struct btISTStiffnessGrowth
{
	double k = 0;           ///< at the start [Pa/m]; 0: not yet
	double volume = 0;      ///< of the overlap at the start [m^3]
	double heldFor = 0;     ///< how long k has waited for an effect [s]
	bool isSecond = false;  ///< the growth before this one had no effect either
};

/// Work that the impulses of a contact did on its two bodies together in the last step [J].
struct btISTContactWork
{
	bool acted = false;  ///< false: the solver did not treat it as volumetric contact of rigid bodies
	double elastic = 0, damping = 0, friction = 0;
};

/// Decides the constants of a pair, once per contact and step, before anything is solved.
class btISTPairRule
{
public:
	virtual ~btISTPairRule() = default;
	/// A and B are in the order of the manifold. `contact` has its trees and its integrals.
	virtual btISTPairConstants decide(
		const btISTContact& contact, const btCollisionObject* bodyA, const btCollisionObject* bodyB) const = 0;
};

/// The rule for bodies without materials (rules (a) and (d) of btContactMaterialTable). The stiffness follows from a depth. At first it
/// is soft: the heavier dynamic body, with its weight on the square of the smaller body's size, sinks in by 0.1 % of that size, which is
/// the cube root of the volume, or of three times the thinner body's thickness (ist::thicknessOf) if that is less. The solver raises k as
/// soon as the bodies press on each other, until they rest at the mean depth `depth` (carryLoad in btContactLaw.h): 0.03 % of the same
/// length, but at least twice the typical error of the two surfaces. Where a body presses by its leaves, both depths are at least the sum
/// of the mean surface gaps and 0.1 % of the size, and at most 0.5 % of it.
/// Weights are 1/2 each; on a half-space its field has all the weight. A body weighs its mass times its own gravity
/// (btRigidBody::getGravity), or times `gravity` if it has none. If neither body can move, the load is the smaller body's weight in
/// water's density. Dissipation is 5 s/m: no body leaves contact faster than 0.2 m/s, and half of the speed comes back at 0.3 m/s. Where
/// gravity g is larger than that of the earth, as in a world of centimetres, it is 49 m/s / g.
class btISTDefaultPairRule : public btISTPairRule
{
public:
	/// `gravity`: gravity for bodies that have none of their own [m/s^2].
	explicit btISTDefaultPairRule(double gravity = 9.81) : m_gravity(gravity) {}
	btISTPairConstants decide(const btISTContact& contact, const btCollisionObject* bodyA, const btCollisionObject* bodyB) const override;

private:
	double m_gravity;  // magnitude [m/s^2]
};

/// The contact of one pair of shapes in one step. A and B are in the order of the manifold. All quantities are in A's mesh frame unless
/// their comment says otherwise. B has no tree if it is one of Bullet's shapes in closed form; a half-space is one of them.
struct btISTContact
{
	static constexpr int kMaxPatches = btISTContactEnergyTank::kMaxPatches;
	static constexpr double kDeep = 0.1;  ///< depth from which on a contact is deep, as a share of the thinner body's thickness

	const btPersistentManifold* manifold = nullptr;
	const btCollisionObject* bodyA = nullptr;
	const btCollisionObject* bodyB = nullptr;
	const btCollisionShape* shapeA = nullptr;  ///< in a compound, the shape of the child; may be deleted once its tree is detached
	const btCollisionShape* shapeB = nullptr;
	std::shared_ptr<const ist::InnerSphereTree> treeA, treeB;
	bool halfSpace = false;
	double volumeB = std::numeric_limits<double>::infinity();  ///< volume of a B without a tree [m^3]; infinite for a half-space

	ist::Pose X_WA;                                  ///< pose of A's mesh frame, which is the frame of its shape (in a compound, the
													 ///< child's)
	ist::Pose X_AB;                                  ///< pose of B's shape in A's, to which the sums belong
	double ahead = 0;                                ///< if positive, the bodies do not touch yet: X_AB is the pose that their free motion
													 ///< reaches after this time [s], and the sums are those of this first touch
	ist::Twist supposedA, supposedB;                 ///< what the motions that `ahead` supposes are more than the free ones, about the
													 ///< centres of mass: others hold or deflect the bodies in this step [World]
	bool deflected = false;                          ///< the sums are those that btISTMotionProbe has found in this step
	ist::Pose startX_WA, startX_AB;                  ///< X_WA and X_AB as the step began
	ist::QueryStatus status = ist::QueryStatus::Ok;  ///< if not Ok, no overlap is claimed and the sums are zero
	ist::OverlapIntegrals total;
	ist::OverlapIntegrals patches[kMaxPatches];
	int patchCount = 0;
	int level = 0;           ///< level of the trees that answered
	double leafDensity = 0;  ///< leaf density of this level (PressureField.h) [1/m^3]
	ist::OverlapError error;
	double depth = 0;             ///< depth of the deepest patch [m]: volume over area, or twice the mean depth within the bodies if less
	double deepest = 0;           ///< largest `depth` since the pair began [m]
	ist::AdaptiveLevel accuracy;  ///< state of two trees with a force tolerance (btISTRegistration::setForceError); otherwise default
	btISTPairConstants constants;
	bool touchMissed = false;  ///< in the last step the pair was so fast, or turned so fast, that its first touch may have been missed
	uint64_t stamp = 0;        ///< btISTContactStore::step() of the last update; if it is older than the present step, the pair sleeps

	/// Impulse on A per patch, written by the solver. World axes, moment about the patch's centroid [N s, N m s].
	ist::Wrench impulses[kMaxPatches];
	double normalImpulse = 0;  ///< sum of their normal components [N s]
	ist::Vec3 pressed;         ///< mean of the normal force on A over about the last 20 ms, World axes [N]; written by the solver
	double grown = 0;          ///< stiffness in the last step of a pair whose stiffness follows from a load [Pa/m]; written by the solver
	btISTStiffnessGrowth growth;  ///< written by the solver
	btISTContactWork work;        ///< written by the solver
	double deepFor = 0;           ///< time since which it has been deep [s]; written by btISTWarnings

	/// Thickness of the thinner of the bodies that have trees (ist::thicknessOf) [m].
	double thickness() const;
	/// Whether the contact is deeper than a tenth of the thinner body, where a body may be pushed through. No body floats too deep.
	bool isDeep() const { return depth > kDeep * thickness() && constants.rule != btISTStiffnessRule::Fluid; }
	/// Whether `ahead` supposes that others hold or deflect one of the bodies.
	bool supposesOthers() const;
	/// Whether it was deep since the pair began.
	bool wasDeep() const { return deepest > kDeep * thickness(); }
	btISTContactEnergyTank tank;  ///< reset as soon as the pair has parted

	bool canPrefetch = false;                 ///< true if the shapes are the bodies' own, not children of a compound
	uint64_t detectionPass = 0;               ///< collision detection pass in which the pair came last; counted only while threads share
											  ///< queries
	int prefetchSlot = -1;                    ///< place of its prefetched result while threads share queries
	std::shared_ptr<btISTVerletList> memory;  ///< its Verlet list of leaf pairs; null: none (btISTRegistration::setVerletLists)

	/// Origin of the sums: a query or the contact cache (btISTContactCache). A cached result has followed the motion to first order.
	btISTCachedResult::Use use = btISTCachedResult::Ask;
	btISTQueryCost cost;  ///< cost since the pair began
	btISTCachedResult kept;
};

/// Stiffness of a pair without materials where no solver raises it: the heavier body's weight on the area of the contact presses it in by
/// the aimed depth. The area counts between a hundredth and all of the square of the smaller body's size. Does nothing to other pairs.
void setStiffnessForArea(btISTContact& contact);

/// Looks for what the motion of a step brings. A solver asks it about bodies that contacts have deflected.
class btISTMotionProbe
{
public:
	/// If the motion in a step of `step` [s] takes the two bodies far deeper into each other than they were as it began, gives the contact
	/// the sums of a pose on the way, with `ahead` and the constants, and returns true. Otherwise only `touchMissed` may change. The
	/// motions are twists of the centres of mass [World]; null for a body that the solver does not move. No allocation.
	virtual bool findDeeper(btISTContact& contact, const ist::Twist* motionA, const ist::Twist* motionB, double step) = 0;
	/// Time [s] after which this motion has taken the two bodies that deep into each other; `step` if it does not. No allocation.
	virtual double timeUntilDeep(const btISTContact& contact, const ist::Twist* motionA, const ist::Twist* motionB, double step) = 0;

protected:
	~btISTMotionProbe() = default;
};

/// The contacts of one world, found by their manifold: the only channel from collision to a solver. One owner thread.
class btISTContactStore
{
public:
	btISTContactStore();
	~btISTContactStore();
	btISTContactStore(const btISTContactStore&) = delete;
	btISTContactStore& operator=(const btISTContactStore&) = delete;

	/// The contact of a manifold; null if the manifold is not ours. Never allocates.
	btISTContact* find(const btPersistentManifold* manifold);
	const btISTContact* find(const btPersistentManifold* manifold) const;

	/// Takes an empty entry from the pool. Its address stays valid until `release`.
	btISTContact* acquire(const btPersistentManifold* manifold);
	void release(const btPersistentManifold* manifold);

	/// All contacts in no particular order, separated pairs (patchCount 0) included.
	const std::vector<btISTContact*>& contacts() const { return m_active; }

	/// Number of the step in progress. A solver calls `nextStep` at its end.
	uint64_t step() const { return m_step; }
	void nextStep() { ++m_step; }

	/// If on, respond-mode pairs with a dissipation also sum their damping (ist::QueryOptions::damping). A solver that uses it switches
	/// it on.
	void sumDamping(bool on) { m_sumsDamping = on; }
	bool sumsDamping() const { return m_sumsDamping; }
	/// If on, respond-mode pairs that the present step would bring into contact get the sums of their first touch (btISTContact::ahead).
	/// A solver that can wait for the touch switches it on.
	void predictTouch(bool on) { m_predictsTouch = on; }
	bool predictsTouch() const { return m_predictsTouch; }
	/// If on, the solver raises the stiffness of pairs without materials by what presses. Otherwise setStiffnessForArea holds for them.
	void raiseStiffness(bool on) { m_raisesStiffness = on; }
	bool raisesStiffness() const { return m_raisesStiffness; }
	/// Null: there is none.
	btISTMotionProbe* motionProbe() const { return m_motionProbe; }
	void setMotionProbe(btISTMotionProbe* probe) { m_motionProbe = probe; }
	/// Times that a pair was so fast, or turned so fast, that its first touch may have been missed (btISTFirstTouch::kMostQueries).
	uint64_t touchesMissed() const { return m_touchesMissed; }
	void countMissedTouch() { ++m_touchesMissed; }

	/// Time that the queries of respond-mode pairs took since the last `resetQueryTime` [s]. It is counted only when switched on, because
	/// it costs two readings of the clock per pair. It is also counted in each pair's `cost`.
	void measureQueryTime(bool on) { m_measures = on; }
	bool measuresQueryTime() const { return m_measures; }
	void addQueryTime(double seconds) { m_querySeconds += seconds; }
	void resetQueryTime() { m_querySeconds = 0; }
	double querySeconds() const { return m_querySeconds; }

	/// Cost of all respond-mode pairs, former ones included, since the store was made or since `resetCost`.
	const btISTQueryCost& cost() const { return m_cost; }
	void resetCost() { m_cost = btISTQueryCost(); }
	/// Counts one step of a pair; `result` is null when the cached result was reused.
	void count(btISTContact& contact, const ist::OverlapResult* result, double seconds);

private:
	std::unordered_map<const btPersistentManifold*, size_t> m_index;  // index in m_active
	std::vector<btISTContact*> m_active, m_free;
	std::vector<std::unique_ptr<btISTContact>> m_pool;
	uint64_t m_step = 1, m_touchesMissed = 0;
	btISTMotionProbe* m_motionProbe = nullptr;
	bool m_measures = false, m_sumsDamping = false, m_predictsTouch = false, m_raisesStiffness = false;
	double m_querySeconds = 0;
	btISTQueryCost m_cost;
};
