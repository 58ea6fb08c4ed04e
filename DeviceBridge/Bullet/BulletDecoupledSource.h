// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "DeviceBridge/Bullet/BulletLocalWorld.h"
#include "DeviceBridge/Bullet/BulletToolContacts.h"
#include "DeviceBridge/Bullet/ToolStiffness.h"
#include "DeviceBridge/Coupling/AdaptiveCoupling.h"
#include "DeviceBridge/Coupling/CouplingSwitch.h"
#include "DeviceBridge/Coupling/DeviceGains.h"
#include "DeviceBridge/Coupling/VirtualCoupling.h"
#include "DeviceBridge/Loop/AnsweringThread.h"
#include "DeviceBridge/Loop/ModelAge.h"
#include "DeviceBridge/Timing/MonotonicClock.h"

class btISTWorld;
class btRigidBody;

namespace devicebridge
{
/// The thread that queries the trees. The world steps in its own thread in every case.
enum class ContactThreading
{
	InHapticThread,  ///< the hand's thread, in each tick
	OwnThread,       ///< a separate thread; between its answers the hand feels a linear model of the last one
	InWorldThread,   ///< the world's thread, once per step; the hand feels linear models only
	// Former names, kept until 0.4.
	InTick = InHapticThread,
	InWorld = InWorldThread
};
using ContactTopology [[deprecated("since 0.3: ContactThreading")]] = ContactThreading;

struct BulletDecoupledSettings
{
	/// Settings with gains for a device and ticks of `period` [s]; BulletToolSettings::forDevice says from where.
	static BulletDecoupledSettings forDevice(const DeviceInfo& info, double period = 1e-3, const AssumptionListener& onAssumed = {})
	{
		BulletDecoupledSettings settings;
		settings.gains = gainsForDevice(info, period, onAssumed);
		return settings;
	}

	CouplingGains gains;
	bool mayBeSilent = false;  ///< whether gains of zero are meant, with which the hand moves nothing and feels nothing
	ist::Pose X_BW;            ///< the device's world W in Bullet's World B
	bool gravity = false;      ///< whether the hand feels the tool's weight
	ContactThreading topology = ContactThreading::InHapticThread;
	bool realTime = true;  ///< whether the contact thread requests SCHED_FIFO
	int priority = 70;     ///< priority of the contact thread; below that of the hand's thread
	/// Number of bodies near the tool that the hand can feel at a time, 1 to kMostMirroredBodies. BulletWorldCoupling::unfelt() names
	/// bodies that found no slot. Each slot takes some 35 kB, which is its share of the snapshots,
	/// questions and answers.
	int slots = kMirroredBodies;
	/// Largest number of pairs of leaves of one query between two trees. A query with more uses a coarser level (TreeLevels.h). Queries of
	/// a closed form have no limit. Negative: no limit for any.
	std::int64_t maxPairs = -1;
	std::int64_t fullUntil = 5'000'000, zeroFrom = 20'000'000;  ///< delays of a model beyond its period: full weight up to, none from [ns]
	double fadeIn = 0.25;                                       ///< time over which a contact that begins inside fades in [s]
	double trustedWay = 0.1;      ///< displacement since the last step up to which a copy has full weight; from twice this it has none [m]
	double trustedModel = 0.005;  ///< the same for a linear model of the tool's contact and the displacement of the tool on the body [m]
};

/// Counters that any thread may read while the source runs.
struct DecoupledStatistics
{
	std::uint64_t worldSteps = 0;         ///< number of world steps that were received
	std::uint64_t modelAnswers = 0;       ///< number of answers of the contact thread, or of the world if that finds the contacts
	std::uint64_t fadedTicks = 0;         ///< number of ticks in which a late model had partial or no weight
	std::uint64_t coarsenedQueries = 0;   ///< number of queries that used a coarser level to stay within the budget
	std::uint64_t queriesOverBudget = 0;  ///< number of queries that exceed the budget at every level; they ran without a budget
	std::uint64_t refusedQueries = 0;     ///< number of queries without an answer (ist::QueryStatus), and so without a force; normally zero
	std::uint64_t droppedPatches = 0;     ///< number of patches beyond two for each slot, which exert no force; normally zero
	/// Number of contacts among the bodies for which a snapshot had no room (contactCapacity); normally zero.
	std::uint64_t droppedContacts = 0;
	std::uint64_t brokenSteps = 0;  ///< number of steps after which the tool had a twist that is not finite (toolIsBroken); normally zero
	bool contactRealTime = false;   ///< whether the contact thread runs, or ran, with SCHED_FIFO
	double modelAge = 0, longestModelAge = 0;  ///< present and longest age of the world's last step [s]
	double period = 0;                         ///< learnt period of the world [s]
};

/// Cost of one answer of the contact thread.
struct ContactAnswerCost
{
	std::uint64_t number = 0;  ///< number of the answer, counted from 1; 0: none yet
	std::int64_t pairs = 0;    ///< number of pairs of leaves that intersect
	/// Processor time since the previous answer, waiting for the question included [us]. 0 for the first answer of a thread that the source
	/// did not start.
	double threadMicroseconds = 0;
	double queryMicroseconds = 0;  ///< part of this time that the queries themselves took [us]
};

/// Contact with a world that another part of the program steps, at any rate and in any thread (decoupled mode). The tool is in no world. In
/// each tick this class integrates the tool on the virtual coupling, against copies of the bodies near it (BulletLocalWorld).
/// BulletWorldCoupling exchanges states and impulses with the world.
///
/// Frames and `ToolStep` are as with BulletContactSource; `ToolContact::other` is the btCollisionObject. When the world is late, contacts
/// fade, and `ToolStep::overdue` tells the stepping thread. When the world goes on, they fade in again.
class BulletDecoupledSource final : public ContactSource
{
public:
	/// `tool` gives mass, inertia, pose, friction and, as the key in the table of materials, stiffness. It is in no world, and its own pose
	/// does not change. Mass 0 is for static couplings: such a tool has no weight. With a dynamic coupling it is refused. `tree` is the
	/// tree of its shape. `tool` must outlive this object, and so must `clock`, the stepping thread's clock.
	BulletDecoupledSource(
		btRigidBody& tool, std::shared_ptr<const ist::InnerSphereTree> tree, Clock& clock, const BulletDecoupledSettings& settings);
	/// A tool whose parts are those of its shape: the shape itself, or the children of a compound at any depth. Their trees
	/// are those that `world` has now. A part without a tree is felt in closed form, by bodies that have a tree. unfeltParts() counts the
	/// others, and BulletWorldCoupling::unfeltReport() names them.
	BulletDecoupledSource(btISTWorld& world, btRigidBody& tool, Clock& clock, const BulletDecoupledSettings& settings);
	~BulletDecoupledSource() override;

	/// Allocates nothing, unless a tree is larger than the tool's and than any passed to reserve().
	void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept override;

	/// Why the tool could not be coupled when it was passed in. If it is not empty, the tool does not move, and neither hand nor tool feels
	/// a force.
	const char* refusal() const noexcept override { return m_refusal; }

	// For any thread:
	void setTopology(ContactThreading topology) noexcept { m_topology.store(topology, std::memory_order_relaxed); }
	/// BulletContactSource::setCoupled.
	void setCoupled(bool on) noexcept { m_switch.set(on || m_settings.gains.isStatic); }
	ContactThreading topology() const noexcept { return m_topology.load(std::memory_order_relaxed); }
	DecoupledStatistics statistics() const noexcept;

	// For the thread that set it up:
	/// Starts the thread for ContactThreading::OwnThread. Returns false if it runs already or cannot be started.
	bool startContactThread();
	void stopContactThread() noexcept;
	/// Computes one answer of that thread on the calling thread, for virtual time. Returns false if there is no question.
	bool serveContacts() noexcept;

	// For the thread of the world:
	/// Reserves the memory for queries of this tree, so that neither a tick nor the contact thread allocates. Call it before the hand
	/// receives a body with this tree. BulletWorldCoupling does so when a body comes near; a call at load time saves that cost in the step.
	/// O(leaves), if no larger tree came before.
	void reserve(const ist::InnerSphereTree& tree);
	[[deprecated("since 0.3: reserve")]] void makeRoom(const ist::InnerSphereTree& tree) { reserve(tree); }
	WorldMirror& mirror() noexcept { return m_mirror; }
	btRigidBody& tool() noexcept { return m_tool; }
	const std::vector<ToolPart>& toolParts() const noexcept { return m_parts; }
	/// Number of parts of the tool's shape that no body can feel: they have no tree and no closed form.
	int unfeltParts() const noexcept { return static_cast<int>(m_unfeltParts.size()); }
	/// These parts, which BulletWorldCoupling::unfeltReport() names.
	const std::vector<UnfeltToolPart>& unfeltToolParts() const noexcept { return m_unfeltParts; }
	/// Tree of the first part of the tool that has one; null if none has.
	std::shared_ptr<const ist::InnerSphereTree> toolTree() const noexcept;
	const BulletDecoupledSettings& settings() const noexcept { return m_settings; }

	// Between ticks, for a balance of momentum:
	/// Sum of the impulses that contacts have given to the tool, in Bullet's World [N s].
	const ist::Vec3& receivedImpulse() const noexcept { return m_local.given(); }
	/// Impulse that the tool has given to bodies and that the world, as far as this object knows, has not taken yet [N s].
	ist::Vec3 undelivered() const noexcept;
	/// State of the tool, in W.
	ToolState toolState() const noexcept;

	// In a tick or between ticks: contacts of the last tick, in Bullet's World.
	int touchingCount() const noexcept { return m_touchingCount; }
	/// A patch, with the tool as A, scaled by its weight.
	const LinearContact& touching(int i) const noexcept { return m_touching[std::size_t(i)]; }
	/// The btCollisionObject that the tool touches there; null if forget() was called for it.
	const void* touched(int i) const noexcept { return mirrored(touching(i).b).id; }
	/// Cost of the newest answer that a tick has taken (ContactThreading::OwnThread).
	ContactAnswerCost lastAnswer() const noexcept { return m_answers.readable().cost; }
	/// Pose of the copy of a body. Returns false and changes nothing if the body is not near.
	bool copyOf(const void* object, ist::Pose& X_WB) const noexcept;

private:
	struct Question
	{
		explicit Question(int slots) : bodies(std::size_t(slots)), pairs(std::size_t(kPairsPerSlot * slots)) {}

		std::uint64_t number = 0;  // 0: no question; it replaced one that was withdrawn
		std::int64_t askedAt = 0;  // [ns]
		ist::Pose X_WT;
		std::vector<MirroredBody> bodies;  // bodies with the poses of the copies
		std::vector<MirroredPair> pairs;
		int pairCount = 0;
	};
	struct Answer
	{
		explicit Answer(int slots) : contacts(std::size_t(kToolContactsPerSlot * slots)) {}

		std::uint64_t number = 0;
		std::int64_t askedAt = 0;
		std::vector<LinearContact> contacts;
		int count = 0;
		double volume = 0, microseconds = 0;
		ContactAnswerCost cost;
		std::uint64_t coarsened = 0, overBudget = 0, refused = 0, dropped = 0;
	};

	BulletDecoupledSource(btRigidBody& tool, std::vector<ToolPart> parts, std::vector<UnfeltToolPart> unfelt, Clock& clock,
		const BulletDecoupledSettings& settings);
	const MirroredBody& mirrored(int slot) const noexcept { return m_mirror.snapshot().bodies[std::size_t(slot)]; }

	void adapt(double dt, const DeviceState& hand) noexcept;
	ist::Wrench pull(double dt, const DeviceState& hand) const noexcept;
	void forgetMomentum(double dt) noexcept;
	void takeSnapshot(std::int64_t now) noexcept;
	void findContacts(std::int64_t now, ToolStep& step) noexcept;
	void askInHapticThread(ToolStep& step) noexcept;
	void takeAnswer() noexcept;
	void feelAnswer(std::int64_t now, ToolStep& step) noexcept;
	void ask(std::int64_t now) noexcept;
	void takeQuestionBack() noexcept;
	bool awaitsAnswer() const noexcept { return m_settled < m_asked; }
	void takeModel(const std::vector<LinearContact>& contacts, int count, double factor) noexcept;
	void weighContacts(double dt, double factor) noexcept;
	void fill(double dt, const ist::Vec3& origin, ToolStep& step) noexcept;
	void post() noexcept;
	bool mayRelease(int slot) const noexcept;

	btRigidBody& m_tool;
	std::vector<ToolPart> m_parts;
	std::vector<UnfeltToolPart> m_unfeltParts;
	int m_slots;
	MonotonicClock m_time;
	BulletDecoupledSettings m_settings;
	AdaptiveCoupling m_coupling;
	CouplingSwitch m_switch;
	ist::Pose m_X_WB;
	double m_leastInertia = 0;
	const char* m_refusal;
	ist::Vec3 m_weight;  // weight of the tool that the hand is to feel, in World [N]
	std::atomic<ContactThreading> m_topology;

	WorldMirror m_mirror;
	ModelAge m_worldAge, m_answerAge;
	BulletLocalWorld m_local;
	BulletToolContacts m_finder;
	std::vector<LinearContact> m_touching;
	int m_touchingCount = 0;
	std::vector<int> m_contactOf;  // place of a slot's contact in the step's list; -1: none
	std::vector<char> m_touched;
	ToolStiffness m_stiffness;
	std::uint64_t m_tick = 0, m_toolAnswers = 0;
	ContactThreading m_lastTopology;

	TripleBuffer<Question> m_questions;
	TripleBuffer<Answer> m_answers;
	BulletToolContacts m_threadFinder;
	double m_threadTime = -1;                   // processor time when the last answer was published; negative: no answer yet on this thread
	std::uint64_t m_asked = 0, m_settled = 0;   // newest question, and newest of those that were answered or withdrawn
	std::vector<std::uint64_t> m_lastQuestion;  // newest question that refers to the trees of the slot
	bool m_triedToTakeBack = false;
	std::atomic<bool> m_contactRealTime{false};

	std::atomic<std::uint64_t> m_worldSteps{0}, m_modelAnswers{0}, m_fadedTicks{0}, m_coarsened{0}, m_overBudget{0}, m_refused{0};
	std::atomic<std::uint64_t> m_brokenSteps{0}, m_dropped{0}, m_droppedContacts{0};
	std::atomic<std::int64_t> m_age{0}, m_longestAge{0}, m_period{0};
	AnsweringThread m_thread;
};
}  // namespace devicebridge
