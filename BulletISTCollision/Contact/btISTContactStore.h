// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTEconomy.h"
#include "BulletISTCollision/Core/Accuracy/PairAccuracy.h"
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
class btISTPairMemory;
struct btISTContact;

/// What decided the stiffness k of a pair.
enum class btISTStiffnessRule
{
	Given,     ///< a material, a fluid, or a rule of the caller; the solver leaves it as it is
	OwnLoad,   ///< the weight of the heavier of the two bodies
	PileLoad,  ///< the weight of all bodies that hang together with the two through contacts
	StepBound  ///< the stiffest that a step of this length can bear (docs/stability.md); the load asks for more
};

/// The constants of a pair in the pressure field law (docs/model.md).
struct btISTPairConstants
{
	double k = 1;                         ///< stiffness [Pa/m]
	double weightA = 0.5, weightB = 0.5;  ///< of A's and of B's field; their sum is 1
	double load = 0;     ///< force that k carries at the depth allowed; the solver raises it to the weight of a pile. 0: k was given [N]
	double gravity = 0;  ///< where k follows from a load: the larger one that acts on the two bodies [m/s^2]
	btISTStiffnessRule rule = btISTStiffnessRule::Given;
	double dissipation = 5;  ///< Hunt-Crossley: the pressure grows by this times the approach speed [s/m]
};

/// What the solver remembers of a pair from step to step while it overlaps.
struct btISTContactLedger
{
	static constexpr int kMaxPatches = btISTKeptResult::kMaxPatches;

	bool open = false;                  ///< false until the first solve of an overlap
	double stored = 0;                  ///< elastic work absorbed and not yet returned: what the pair may still give back [J]
	ist::Vec3 direction;                ///< of the force on A when it last had one direction, World; zero before
	ist::Wrench friction[kMaxPatches];  ///< of the last step, on A, World, about the patch: where the next one begins to look [N, N m]
};

/// What the impulses of a contact did to the motion of its two bodies together in the last step [J].
struct btISTContactWork
{
	bool acted = false;  ///< false: not solved as volumetric contact of rigid bodies
	double elastic = 0, damping = 0, friction = 0;
};

/// Decides the constants of a pair, once per contact and step, before anything is solved.
class btISTPairRule
{
public:
	virtual ~btISTPairRule() = default;
	/// A and B in the order of the manifold. `contact` has its trees and its integrals.
	virtual btISTPairConstants decide(
		const btISTContact& contact, const btCollisionObject* bodyA, const btCollisionObject* bodyB) const = 0;
};

/// For bodies without materials (rules (a) and (d) of btContactMaterialTable): under its weight the heavier dynamic body, on the square of
/// the smaller body's size, sinks by the sum of the mean surface gaps, but by at least 0.1 % and at most 0.5 % of that size. Size: cube
/// root of the volume. A sheet is thinner than its size, so nothing sinks by more than a twentieth of the thinner body's thickness
/// (ist::thicknessOf). Weights 1/2, or all on a half-space. A body weighs its mass times its own gravity (btRigidBody::getGravity), or
/// times `gravity` where it has none. Where neither body can move, the load is the smaller one made of water. Dissipation: 5 s/m, so that
/// nothing leaves contact faster than 0.2 m/s and half of the speed comes back at 0.3 m/s.
class btISTDefaultPairRule : public btISTPairRule
{
public:
	/// Of bodies that have no gravity of their own [m/s^2].
	explicit btISTDefaultPairRule(double gravity = 9.81) : m_gravity(gravity) {}
	btISTPairConstants decide(const btISTContact& contact, const btCollisionObject* bodyA, const btCollisionObject* bodyB) const override;

private:
	double m_gravity;  // magnitude [m/s^2]
};

/// What one pair of shapes has to say in one step. A and B are in the order of the manifold; everything is in A's mesh frame
/// unless said otherwise. B has no tree when it is one of Bullet's shapes in closed form, a half-space among them.
struct btISTContact
{
	static constexpr int kMaxPatches = btISTContactLedger::kMaxPatches;

	const btPersistentManifold* manifold = nullptr;
	const btCollisionObject* bodyA = nullptr;
	const btCollisionObject* bodyB = nullptr;
	const btCollisionShape* shapeA = nullptr;  ///< of the child, in a compound; may be gone once its tree is detached
	const btCollisionShape* shapeB = nullptr;
	std::shared_ptr<const ist::InnerSphereTree> treeA, treeB;
	bool halfSpace = false;
	double volumeB = std::numeric_limits<double>::infinity();  ///< of a B without a tree [m^3]; infinite for a half-space

	ist::Pose X_WA;                                  ///< of A's mesh frame, which is the frame of its shape (of the child, in a compound)
	ist::Pose X_AB;                                  ///< of B's shape in A's: where the sums are those of
	ist::QueryStatus status = ist::QueryStatus::Ok;  ///< other than Ok: no overlap is claimed, and the sums are zero
	ist::OverlapIntegrals total;
	ist::OverlapIntegrals patches[kMaxPatches];
	int patchCount = 0;
	int level = 0;           ///< of the trees that answered
	double leafDensity = 0;  ///< of these trees (PressureField.h) [1/m^3]
	ist::OverlapError error;
	double depth = 0;            ///< of the deepest patch, volume over area [m]
	double deepest = 0;          ///< largest `depth` since the pair began [m]
	ist::PairAccuracy accuracy;  ///< of two trees, where a force error is accepted (btISTRegistration::setForceError); blank otherwise
	btISTPairConstants constants;
	uint64_t stamp = 0;  ///< btISTContactStore::step() when it was filled. An older stamp is stale: the pair sleeps

	/// Written by the solver: impulse on A per patch, World axes, moment about the patch's centroid [N s, N m s].
	ist::Wrench impulses[kMaxPatches];
	double normalImpulse = 0;  ///< their normal parts, added up [N s]
	double pressed = 0;        ///< written by the solver: mean of the normal force over the last ten steps or so [N]
	btISTContactWork work;     ///< written by the solver

	/// Thickness of the thinner of the bodies that have trees (ist::thicknessOf) [m].
	double thickness() const;
	btISTContactLedger ledger;  ///< blank again as soon as the pair has parted

	bool foreseeable = false;                 ///< the shapes are where their bodies are, and not children of a compound
	uint64_t pass = 0;                        ///< of collision detection, in which it was last met; counted where threads share queries
	int ahead = -1;                           ///< where threads that share queries have its answer
	std::shared_ptr<btISTPairMemory> memory;  ///< of its pairs of leaves; null: none (btISTRegistration::setPairMemory)

	/// How the sums came about: see btISTEconomy. What was kept has followed the motion to first order.
	btISTKeptResult::Use use = btISTKeptResult::Ask;
	btISTQueryCost cost;  ///< since the pair began
	btISTKeptResult kept;
};

/// The contacts of one world, found by their manifold: the only channel from collision to a solver. One owner thread.
class btISTContactStore
{
public:
	btISTContactStore();
	~btISTContactStore();
	btISTContactStore(const btISTContactStore&) = delete;
	btISTContactStore& operator=(const btISTContactStore&) = delete;

	/// Null when the manifold is not ours. Never allocates.
	btISTContact* find(const btPersistentManifold* manifold);
	const btISTContact* find(const btPersistentManifold* manifold) const;

	/// A blank entry from the pool; its address stays until `release`.
	btISTContact* acquire(const btPersistentManifold* manifold);
	void release(const btPersistentManifold* manifold);

	/// In no particular order; separated pairs among them (patchCount 0).
	const std::vector<btISTContact*>& contacts() const { return m_active; }

	/// Number of the step in progress; a solver calls `nextStep` when it is done.
	uint64_t step() const { return m_step; }
	void nextStep() { ++m_step; }

	/// Whether the sums of respond-mode pairs have their damping (ist::QueryOptions::damping) where the pair has a dissipation: for a
	/// solver that uses it.
	void sumDamping(bool on) { m_sumsDamping = on; }
	bool sumsDamping() const { return m_sumsDamping; }

	/// Time that the queries of respond-mode pairs took since the last `resetQueryTime` [s]; counted only when switched on,
	/// for two readings of the clock a pair.
	/// Also counted in each pair's `cost`.
	void measureQueryTime(bool on) { m_measures = on; }
	bool measuresQueryTime() const { return m_measures; }
	void addQueryTime(double seconds) { m_querySeconds += seconds; }
	void resetQueryTime() { m_querySeconds = 0; }
	double querySeconds() const { return m_querySeconds; }

	/// Of all respond-mode pairs since the store was made or `resetCost`, those that are gone among them.
	const btISTQueryCost& cost() const { return m_cost; }
	void resetCost() { m_cost = btISTQueryCost(); }
	/// After a step of a pair; `result` is null when it was kept.
	void count(btISTContact& contact, const ist::OverlapResult* result, double seconds);

private:
	std::unordered_map<const btPersistentManifold*, size_t> m_index;  // into m_active
	std::vector<btISTContact*> m_active, m_free;
	std::vector<std::unique_ptr<btISTContact>> m_pool;
	uint64_t m_step = 1;
	bool m_measures = false, m_sumsDamping = false;
	double m_querySeconds = 0;
	btISTQueryCost m_cost;
};
