// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "DeviceBridge/Loop/ContactSource.h"
#include "DeviceBridge/Loop/LinearContact.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge
{
constexpr int kMirroredBodies = 16;        ///< number of slots for bodies, unless a setting gives another
constexpr int kMostMirroredBodies = 1024;  ///< largest number of slots
constexpr int kPairsPerSlot = 8;           ///< capacity of pairs of parts, over the number of slots
constexpr int kContactsPerSlot = 3;        ///< capacity of contacts of the mirrored bodies, over the number of slots
constexpr int kFewestContacts = 48;        ///< smallest capacity of these contacts: one body may rest on many
constexpr int kToolContactsPerSlot = 2;    ///< capacity of patches of the tool, over the number of slots

/// Largest number of contacts of the mirrored bodies that a snapshot shows.
constexpr int contactCapacity(int slots) { return slots * kContactsPerSlot > kFewestContacts ? slots * kContactsPerSlot : kFewestContacts; }

/// The impulse that the hand's thread has given to one body since the body entered its slot. It includes the state of that thread's copy of
/// the body, in World.
struct SpentImpulse
{
	std::uint64_t epoch = 0;  ///< epoch of the slot's body; 0: none
	bool released = false;    ///< whether the hand's thread will give no further impulse to this body
	ist::Wrench impulse;      ///< sum of impulses; moment about the copy's centre of mass [N s, N m s]
	ist::Wrench area;         ///< time integral of `impulse`, from which the displacement of the body follows [N s^2, N m s^2]
	double seconds = 0;       ///< duration of that integral [s]
	ist::Pose X_WB;
	ist::Twist twist;
	ist::Vec3 shifted, turned;  ///< sum of the corrections of the copy's position and rotation so far [m, rad]
	ist::Twist quickened;       ///< sum of the corrections of the copy's twist so far
};

/// One body near the tool, as the world has it after a step, in World axes. B is the body's centre-of-mass frame. Bullet has the shape in
/// the same frame.
struct MirroredBody
{
	std::uint64_t epoch = 0;  ///< number that grows with each new body in the slot; 0: the slot is empty
	bool leaving = false;     ///< whether the body is to be released
	const void* id = nullptr;
	ist::Pose X_WB;
	ist::Twist twist;                            ///< velocity of the centre of mass
	ist::Vec3 inverseMass;                       ///< inverse mass per World axis; zero: the body does not move [1/kg]
	ist::Mat3 inverseInertia = ist::zeroMat3();  ///< inverse inertia in axes of B [1/(kg m^2)]
	ist::Vec3 gravity;                           ///< [m/s^2]
	double friction = 0;                         ///< Coulomb's coefficient of the pair of tool and body
	SpentImpulse seen;                           ///< impulse that the world had received from the hand before this step
};

/// A part of the tool and a part of a body near it. A body has one part, or those of its compound. P is the part's frame: the mesh frame of
/// its tree, or the frame of its closed form.
struct MirroredPair
{
	int slot = 0, toolPart = 0, bodyPart = 0;
	const ist::InnerSphereTree* tree = nullptr;       ///< tree of the body's part, valid while the body has the slot; null: `field`
	ist::AnyField field;                              ///< closed form of a part without a tree
	ist::Pose X_BP;                                   ///< pose of the part in its body
	double k = 0, toolWeight = 0.5, dissipation = 0;  ///< contact constants
	double restDepth = 0;                             ///< LinearContact::restDepth
};

struct WorldSnapshot
{
	explicit WorldSnapshot(int slots = kMirroredBodies)
		: bodies(std::size_t(slots)),
		  pairs(std::size_t(kPairsPerSlot * slots)),
		  contacts(std::size_t(contactCapacity(slots))),
		  toolContacts(std::size_t(kToolContactsPerSlot * slots))
	{}

	std::uint64_t step = 0;
	double period = 0;  ///< duration of the step [s]
	std::vector<MirroredBody> bodies;
	std::vector<MirroredPair> pairs;  ///< in the order of their slots
	int pairCount = 0;
	std::vector<LinearContact> contacts;  ///< contacts of the mirrored bodies with each other and with other bodies
	int contactCount = 0;
	std::uint64_t droppedContacts = 0;        ///< number of such contacts that found no place, summed over the steps
	std::vector<LinearContact> toolContacts;  ///< contacts of the tool, found by the world's thread at the tool's pose there
	int toolContactCount = 0;
	// Counts of these queries, as in DecoupledStatistics, summed over the steps:
	std::uint64_t coarsenedQueries = 0, queriesOverBudget = 0, refusedQueries = 0, droppedPatches = 0;
};

/// The hand's thread's data of one tick.
struct HandPost
{
	explicit HandPost(int slots = kMirroredBodies) : bodies(std::size_t(slots)) {}

	std::uint64_t tick = 0;
	ToolState tool;  ///< state of the tool in World
	std::vector<SpentImpulse> bodies;
};

/// Exchange between the thread that owns a world and the thread that owns a hand. The world publishes after each step, and the hand posts
/// in each tick. Neither waits, and nothing allocates. Impulses are posted as sums since the body entered, so no impulse is lost if a post
/// is overwritten before it is read. The impulses that the world takes add up exactly to those that the hand gave.
///
/// A slot is emptied in two steps. First the world marks its body as leaving; then the hand posts the body as released. Only then has the
/// world taken the last impulse, so that it may release the trees.
class WorldMirror
{
public:
	using Trees = std::vector<std::shared_ptr<const ist::InnerSphereTree>>;

	/// `slots`: 1 to kMostMirroredBodies. All memory is allocated here.
	explicit WorldMirror(int slots = kMirroredBodies);
	int slots() const noexcept { return m_slots; }

	// For the thread of the world:
	/// Fetches the latest post. The impulses that are new since the last collect() are in `taken`, one per slot.
	void collect() noexcept;
	const HandPost& posted() const noexcept { return m_posts.readable(); }
	/// Impulse that one body received between the last two calls of collect().
	struct Taken
	{
		ist::Wrench impulse;
		double share = 0;  ///< mean share of that time before the impulse was given, weighted with the impulse; 1/2 for a steady force
		double seconds = 0;
	};
	const Taken& taken(int slot) const noexcept { return m_taken[std::size_t(slot)]; }
	/// The slot of `id`, or -1 if it has none.
	int find(const void* id) const noexcept;
	/// A slot for a new body, or -1 if all are occupied. The slot owns a share of the trees until the body is released.
	int admit(const void* id, Trees trees = {}) noexcept;
	void leave(int slot) noexcept { body(slot).leaving = true; }
	/// Empties the slot if its body was released. Returns true if so.
	bool releaseIfDone(int slot) noexcept;
	/// Marks every body as leaving and forgets its id, because the owner of the ids is gone.
	void leaveAll() noexcept;
	/// Removes and publishes: no bodies, no contacts, no trees. Call it only while the hand's threads are stopped.
	void clear() noexcept;
	/// The body to fill before publish(). The mirror itself sets epoch, leaving, id and seen.
	MirroredBody& body(int slot) noexcept { return m_bodies[std::size_t(slot)]; }
	/// The snapshot whose pairs and contacts are to be filled before publish(). It holds older values.
	WorldSnapshot& writable() noexcept { return m_snapshots.writable(); }
	void publish(double period) noexcept;

	// For the thread of the hand:
	bool fetch() noexcept { return m_snapshots.fetch(); }
	const WorldSnapshot& snapshot() const noexcept { return m_snapshots.readable(); }
	/// The post, of which every field is to be filled.
	HandPost& post() noexcept { return m_posts.writable(); }
	void send() noexcept { m_posts.publish(); }

private:
	int m_slots;
	TripleBuffer<WorldSnapshot> m_snapshots;
	TripleBuffer<HandPost> m_posts;
	std::vector<MirroredBody> m_bodies;
	std::vector<Trees> m_trees;
	std::vector<Taken> m_taken;
	std::uint64_t m_epochs = 0, m_steps = 0;
};
}  // namespace devicebridge
