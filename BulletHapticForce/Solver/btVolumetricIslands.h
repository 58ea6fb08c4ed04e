// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btCompensatedPoses.h"
#include "BulletHapticForce/Solver/btContactEnergyTank.h"
#include "BulletHapticForce/Solver/btIslandBlockSolver.h"
#include "BulletHapticForce/Solver/btVolumetricStatistics.h"

#include "BulletDynamics/ConstraintSolver/btSolverConstraint.h"

#include <limits>
#include <memory>
#include <vector>

class btRigidBody;
struct btSolverBody;

/// The volumetric contacts of one call of Bullet's solver, grouped into islands: bodies that are connected through such contacts, and
/// through joints. btIslandBlockSolver solves an island at once, with the rows of its joints. An island that is too large for it is solved
/// patch by patch, in Bullet's iterations; its joints stay Bullet's. An island takes part in no iteration when no other row of Bullet moves
/// its bodies, because that would change nothing. With nothing set, it is solved again where a tank holds less energy than its contact
/// would return.
///
/// Joints join islands in Bullet's order, as long as the sum is not too large. All other joints stay Bullet's, as do those of islands
/// without volumetric contact.
///
/// `bodies` is always Bullet's pool of solver bodies. Allocates nothing after the largest scene has been seen.
class btVolumetricIslands
{
public:
	static constexpr int kMaxBlockBodies = 64, kMaxBlockPatches = 256;

	/// Reserves memory for so many contacts with all their patches.
	void reserve(size_t contacts);
	/// Reserves memory for all bodies of the world, touching or not.
	void reserveBodies(size_t bodies);
	void clear();
	/// True when the body's velocity (including the forces of this step), position and mass are finite. Other bodies must not reach an
	/// island, because one such value would spoil the whole island.
	static bool isFinite(const btSolverBody& body);
	/// Adds all patches of a contact between two bodies of the pool. At least one of the bodies must be able to move.
	void add(btISTContact& contact, int bodyA, int bodyB, const btContactFriction& friction);
	/// Before a solve is repeated because a contact gets other sums: its patches of this solve take part in the next one, too, as points
	/// that push along their normals.
	void keep(const btISTContact& contact);
	void forgetKept() { m_kept.clear(); }
	/// Lets all bodies of this body's island move for the first `time` [s] of the step only.
	void hold(int body, double time);
	/// Adds the rows of all joints, in Bullet's order. `prepare` takes those that it solves out of Bullet's iterations. Call it after the
	/// last `add`. `rows` must live until `finish`.
	void addJoints(btConstraintArray& rows, const btSolverBody* bodies);
	/// Builds the islands; call it after the last `add`. `touched` are the bodies that Bullet's rows of contacts move. `h` is the step [s],
	/// and `step` its number in the store.
	void prepare(const btSolverBody* bodies, int bodyCount, const std::vector<int>& touched, double h, uint64_t step);
	/// Visits every island once. Returns the largest squared change of a force impulse [N^2 s^2].
	double iterate(btSolverBody* bodies, int iteration);
	/// Computes the change of each body's twist by all these patches. Other contacts may add theirs before `finish`.
	std::vector<ist::Twist>& sumChanges(const btSolverBody* bodies);
	/// Limits every contact to its energy tank (btContactEnergyTank.h): the bodies then have the motion of this solution. Call it after
	/// `sumChanges`. A second call for the same solution does nothing.
	void holdToEnergyTanks(btSolverBody* bodies);
	/// Does so, and writes the impulses into the contacts. Call it after `sumChanges`.
	void finish(btSolverBody* bodies);
	/// Call this after Bullet has written the velocities into the bodies: see btCompensatedPoses.
	void settlePoses();
	/// Counters; they are never reset.
	const btVolumetricStatistics& statistics() const { return m_statistics; }
	btVolumetricStatistics& statistics() { return m_statistics; }

private:
	struct Entry
	{
		btISTContact* contact = nullptr;
		int patchIndex = 0;
		int bodyA = 0, bodyB = 0;
		btContactFriction friction;
		btContactPatch patch;
		bool kept = false;  // of former sums of the contact, which `patch` describes as the step begins
		int next = -1;      // next entry of the same island
		ist::Wrench impulse, elastic;
		double normalImpulse = 0;
	};
	/// The rows of one joint.
	struct Joint
	{
		btSolverConstraint* rows = nullptr;
		int count = 0;
		int bodyA = 0, bodyB = 0;
		bool finite = true;
		int next = -1;  // next joint of the same island
	};
	struct Size
	{
		int bodies = 0, patches = 0;
	};
	struct Island
	{
		int first = -1, entryCount = 0, bodyCount = 0;
		int firstJoint = -1;
		bool touched = false;
		double moves = std::numeric_limits<double>::infinity();  // time of the step in which its bodies move [s]
		double weight = 0;                                       // weight of the bodies that have a gravity of their own [N]
		double weightlessMass = 0;                               // mass of the other bodies [kg]
	};
	struct Block
	{
		btIslandBlockSolver solver;
		std::vector<int> bodies, entries;
		std::vector<btSolverConstraint*> jointRows;
		std::vector<ist::Twist> free;
		std::vector<ist::Wrench> impulses;  // change of the impulses on each body, about its centre of mass
	};
	struct Row
	{
		btVolumetricRow row;
		int entry = 0;
	};

	int rootOf(int body);
	/// A body of the joint that can move.
	static int movableBody(const Joint& joint, const btSolverBody* bodies);
	void joinByJoints(const btSolverBody* bodies);
	void takeJoints(const btSolverBody* bodies);
	void addJointRows(Block& block, const Joint& joint, const btSolverBody* bodies);
	void takeBackJoints(Block& block, const btSolverBody* bodies) const;
	double sumJoints(Block& block, const btSolverBody* bodies) const;
	void findIslands(const btSolverBody* bodies, const std::vector<int>& touched);
	void weigh(const btSolverBody* bodies);
	void findMotors(const btSolverBody* bodies);
	static ist::Twist freeTwist(const Entry& e, const btSolverBody* bodies);
	void carryLoads(const btSolverBody* bodies);
	void waitForTouch(const btSolverBody* bodies);
	void leaveOutRolling(Entry& e, const btSolverBody* bodies) const;
	void leaveOutSlidingAndRolling(const btSolverBody* bodies);
	static void centre(Entry& e, const btSolverBody* bodies, double speed);
	void holdBodies(btSolverBody* bodies);
	void displaceByRounding(const btSolverBody* bodies);
	void openEnergyTanks(const btSolverBody* bodies);
	static bool fitsBlock(const Island& island);
	void reserve(Block& block) const;
	void fill(Block& block, const Island& island, const btSolverBody* bodies);
	void makeRows(const Island& island, const btSolverBody* bodies);
	double solve(Block& block, btSolverBody* bodies);
	double solvePassing(const Island& island, btSolverBody* bodies);
	bool softenToEnergyTanks(const Island& island, const btSolverBody* bodies);
	double solve(Row& row, btSolverBody* bodies);
	void addChange(const Entry& e, const ist::Wrench& impulse, const btSolverBody* bodies);
	enum class Own
	{
		Contact,
		ContactAfterOthers,  // the same, with the motion before that all other contacts gave
		All
	};
	void gatherEnergyTank(size_t first, int count, const btSolverBody* bodies, Own whose, btEnergyTankPatch* patches) const;
	double shareOf(size_t first, int count, const btSolverBody* bodies, Own whose) const;
	/// Calls `act` with the first entry of each contact of the island, and the number of its entries. They follow one another.
	template <class Act> void forEachContact(const Island& island, const Act& act) const
	{
		for (int i = island.first; i >= 0;)
		{
			const size_t first = size_t(i);
			int count = 0;
			for (; i >= 0 && m_entries[size_t(i)].contact == m_entries[first].contact; i = m_entries[size_t(i)].next) ++count;
			act(first, count);
		}
	}
	void scale(Entry& e, double share, btSolverBody* bodies);
	void holdToEnergyTanks(const Island& island, btSolverBody* bodies);
	void enterWork(const Island& island, const btSolverBody* bodies);

	double m_step = 0;
	uint64_t m_stepNumber = 0;
	size_t m_reserved = 0;  // number of contacts
	std::vector<Entry> m_entries, m_kept;
	std::vector<Joint> m_joints;
	std::vector<Size> m_sizes;  // of the island of each root, while joints join islands
	std::vector<Island> m_islands;
	std::vector<int> m_parent, m_islandOfRoot, m_indexInBlock;
	std::vector<int> m_patchesOf;                   // number of patches at each body that can move
	std::vector<double> m_motors;                   // largest force of a motor at each body [N]
	Block m_passing;                                // islands that no other row moves
	std::vector<std::unique_ptr<Block>> m_lasting;  // islands that are solved in every iteration
	size_t m_lastingCount = 0;
	std::vector<Row> m_rows;
	std::vector<ist::Twist> m_change;  // change of each body's twist by all volumetric contacts
	bool m_heldToEnergyTanks = false;
	btCompensatedPoses m_unrounded;
	std::vector<btRigidBody*> m_moved;
	std::vector<std::pair<btRigidBody*, double>> m_held;  // with the time in which they do not move [s]
	btVolumetricStatistics m_statistics;
};
