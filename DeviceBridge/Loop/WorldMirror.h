// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <memory>

#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "DeviceBridge/Loop/ContactSource.h"
#include "DeviceBridge/Loop/LinearContact.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge
{
constexpr int kMirroredBodies = 16;
constexpr int kMirroredContacts = 48;
constexpr int kToolContacts = 16;

/// What the hand's thread has given to one body since it entered its slot. The body's own copy there, in World.
struct SpentImpulse
{
	std::uint64_t epoch = 0;  ///< that of the slot's tenant; 0: none
	bool released = false;    ///< nothing more will be spent on this tenant
	ist::Wrench impulse;      ///< moment about the copy's centre of mass [N s, N m s]
	ist::Wrench area;         ///< Int impulse dt, from which follows how far it has carried the body
	double seconds = 0;       ///< over which that integral runs
	ist::Pose X_WB;
	ist::Twist twist;
	ist::Vec3 shifted, turned;  ///< how far the copy was put right so far
};

/// One body near the tool, as the world has it after a step. World axes; B is the body's centre-of-mass frame, in which Bullet has
/// the shape as well, so that it is the tree's mesh frame.
struct MirroredBody
{
	std::uint64_t epoch = 0;  ///< grows with each tenant of the slot; 0: nobody
	bool leaving = false;     ///< to be released
	const void* id = nullptr;
	const ist::InnerSphereTree* tree = nullptr;  ///< lives as long as the tenant. Null: the half-space below
	ist::Vec3 planeNormal;                       ///< World, pointing out
	double planeOffset = 0;
	ist::Pose X_WB;
	ist::Twist twist;                                 ///< of the centre of mass
	ist::Vec3 inverseMass;                            ///< per World axis; zero: not to be moved [1/kg]
	ist::Mat3 inverseInertia = ist::zeroMat3();       ///< axes of B [1/(kg m^2)]
	ist::Vec3 gravity;                                ///< [m/s^2]
	double k = 0, toolWeight = 0.5, dissipation = 0;  ///< constants of the pair of tool and body
	double friction = 0;
	SpentImpulse seen;  ///< what the world knew of the hand before this step
};

struct WorldSnapshot
{
	std::uint64_t step = 0;
	double period = 0;  ///< of the step [s]
	MirroredBody bodies[kMirroredBodies];
	LinearContact contacts[kMirroredContacts];  ///< of the bodies with each other, and with what is not mirrored
	int contactCount = 0;
	LinearContact toolContacts[kToolContacts];  ///< of the tool, found by the world's thread where the tool was
	int toolContactCount = 0;
};

/// What the hand's thread says in every tick.
struct HandPost
{
	std::uint64_t tick = 0;
	ToolState tool;  ///< in World
	SpentImpulse bodies[kMirroredBodies];
};

/// Between the thread that owns a world and the one that owns a hand. The world publishes after each step, the hand posts in each
/// tick; nobody waits, and nothing allocates. Impulses are posted as sums since the body entered, so that a post that is overwritten
/// unread loses nothing: what the world takes adds up to exactly what the hand gave.
///
/// A slot is emptied in two steps: the world marks its tenant as leaving, the hand posts that it is released, and only then has the
/// world taken the last impulse and may let go of the tree.
class WorldMirror
{
public:
	// Thread of the world:
	/// Takes the latest post. What is new in it is in `taken`, slot by slot.
	void collect() noexcept;
	const HandPost& posted() const noexcept { return m_posts.readable(); }
	/// Since the collect before the last.
	struct Taken
	{
		ist::Wrench impulse;
		double share = 0;  ///< of the time for which the impulse had not been given yet, weighted with it; 1/2 for a steady force
		double seconds = 0;
	};
	const Taken& taken(int slot) const noexcept { return m_taken[slot]; }
	/// The slot of `id`, or -1.
	int find(const void* id) const noexcept;
	/// A slot for a new tenant, or -1 when all are taken. The tree is kept until the tenant is released, whoever else lets go of it.
	int admit(const void* id, std::shared_ptr<const ist::InnerSphereTree> tree = nullptr) noexcept;
	const std::shared_ptr<const ist::InnerSphereTree>& tree(int slot) const noexcept { return m_trees[slot]; }
	void leave(int slot) noexcept { m_bodies[slot].leaving = true; }
	/// Empties the slots whose tenants were released; true for those.
	bool releaseIfDone(int slot) noexcept;
	/// Every tenant leaves, its id forgotten: who admitted them is not there any more.
	void leaveAll() noexcept;
	/// While the hand's threads are stopped: no tenants, no contacts, no trees, and so it is published.
	void clear() noexcept;
	/// To be filled before publish(); epoch, leaving, id, tree and seen are the mirror's.
	MirroredBody& body(int slot) noexcept { return m_bodies[slot]; }
	/// For contacts, to be filled before publish(). Holds an older snapshot.
	WorldSnapshot& writable() noexcept { return m_snapshots.writable(); }
	void publish(double period) noexcept;

	// Thread of the hand:
	bool fetch() noexcept { return m_snapshots.fetch(); }
	const WorldSnapshot& snapshot() const noexcept { return m_snapshots.readable(); }
	/// To be filled in whole.
	HandPost& post() noexcept { return m_posts.writable(); }
	void send() noexcept { m_posts.publish(); }

private:
	TripleBuffer<WorldSnapshot> m_snapshots;
	TripleBuffer<HandPost> m_posts;
	MirroredBody m_bodies[kMirroredBodies];
	std::shared_ptr<const ist::InnerSphereTree> m_trees[kMirroredBodies];
	Taken m_taken[kMirroredBodies];
	std::uint64_t m_epochs = 0, m_steps = 0;
};
}  // namespace devicebridge
