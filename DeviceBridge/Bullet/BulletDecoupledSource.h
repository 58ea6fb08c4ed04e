// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <memory>

#include "DeviceBridge/Bullet/BulletLocalWorld.h"
#include "DeviceBridge/Bullet/BulletToolContacts.h"
#include "DeviceBridge/Coupling/AdaptiveCoupling.h"
#include "DeviceBridge/Coupling/VirtualCoupling.h"
#include "DeviceBridge/Loop/AnsweringThread.h"
#include "DeviceBridge/Loop/ModelAge.h"
#include "DeviceBridge/Timing/SteadyTime.h"

class btRigidBody;

namespace devicebridge
{
/// Which thread asks the trees. The world steps in its own thread in every case.
enum class ContactThreading
{
	InHapticThread,  ///< the hand's thread, in each tick
	OwnThread,       ///< one of its own; in between the hand feels the last answer as a linear model
	InWorldThread,   ///< the world's, once a step: the hand feels linear models only
	// Former names, until 0.4.
	InTick = InHapticThread,
	InWorld = InWorldThread
};
using ContactTopology [[deprecated("since 0.3: ContactThreading")]] = ContactThreading;

struct BulletDecoupledSettings
{
	CouplingGains gains;
	ist::Pose X_BW;        ///< the device's world W in Bullet's World B
	bool gravity = false;  ///< does the tool weigh on the hand?
	ContactThreading topology = ContactThreading::InHapticThread;
	bool realTime = true;        ///< ask for SCHED_FIFO for the contact thread
	int priority = 70;           ///< of it; below that of the hand's thread
	std::int64_t maxPairs = -1;  ///< budget of a query; beyond it a coarser level answers (TreeLevels.h). Negative: none
	std::int64_t fullUntil = 5'000'000,
				 zeroFrom = 20'000'000;  ///< a model that is so much later than expected counts in full, for nothing [ns]
	double fadeIn = 0.25;                ///< of a contact that begins inside [s]
	double trustedWay = 0.1;      ///< a copy counts in full up to this way since the last step, and for nothing from twice that on [m]
	double trustedModel = 0.005;  ///< the same for a linear model of the tool's contact, and the way of the tool on the body [m]
};

/// Readable while it runs, from any thread.
struct DecoupledStatistics
{
	std::uint64_t worldSteps = 0;         ///< that were seen
	std::uint64_t modelAnswers = 0;       ///< of the contact thread, or of the world where that finds the contacts
	std::uint64_t fadedTicks = 0;         ///< in which a model was so late that it counted in part or for nothing
	std::uint64_t coarsenedQueries = 0;   ///< answered by a coarser level, to keep the budget
	std::uint64_t queriesOverBudget = 0;  ///< that no level could answer within it; asked without
	std::uint64_t refusedQueries = 0;     ///< without an answer (ist::QueryStatus), and so without a force; none in good health
	std::uint64_t brokenSteps = 0;        ///< after which the tool's twist was not finite (ToolStep::toolIsBroken); none in good health
	bool contactRealTime = false;         ///< the contact thread runs, or ran, with SCHED_FIFO
	double modelAge = 0, longestModelAge = 0;  ///< of the world [s]
	double period = 0;                         ///< of the world, as learnt [s]
};

/// What one answer of the contact thread took.
struct ContactAnswerCost
{
	std::uint64_t number = 0;  ///< of the answer, counted from 1; 0: none yet
	std::int64_t pairs = 0;    ///< intersecting leaves
	/// On a processor since the answer before, waiting for the question included [us]. 0 for the first of a thread that is not the source's
	/// own.
	double threadMicroseconds = 0;
	double queryMicroseconds = 0;  ///< of this, in the queries themselves
};

/// Contact with a world that somebody else steps, at any rate and in any thread (decoupled mode). The tool is in no world: this
/// integrates it on the virtual coupling, in each tick, against copies of the bodies near it (BulletLocalWorld). BulletWorldCoupling
/// carries what happens to and fro.
///
/// Frames and `ToolStep` as with BulletContactSource; `ToolContact::other` is the btCollisionObject. When the world is late, contacts
/// fade, and `ToolStep::overdue` says so to the stepping thread; after that they fade in anew.
class BulletDecoupledSource final : public ContactSource
{
public:
	/// `tool` gives mass, inertia, pose, friction and, as the key in the table of materials, stiffness. It is in no world; its own pose
	/// stays as it is. Mass 0 is for static couplings: such a tool weighs nothing. With a dynamic coupling it is refused.
	/// `tree` speaks for its shape. `tool` and `clock`, which is that of the stepping thread, outlive this.
	BulletDecoupledSource(
		btRigidBody& tool, std::shared_ptr<const ist::InnerSphereTree> tree, Clock& clock, const BulletDecoupledSettings& settings);
	~BulletDecoupledSource() override;

	/// Allocates nothing but where a tree is larger than the tool's and any that reserve() was told of.
	void advance(double dt, const DeviceState& hand, ToolStep& step) noexcept override;

	/// whyNotCoupled() of the tool as it came. If it is not empty, the tool stays where it is, and neither hand nor tool feels anything.
	const char* refusal() const noexcept override { return m_refusal; }

	// From any thread:
	void setTopology(ContactThreading topology) noexcept { m_topology.store(topology, std::memory_order_relaxed); }
	ContactThreading topology() const noexcept { return m_topology.load(std::memory_order_relaxed); }
	DecoupledStatistics statistics() const noexcept;

	// From the thread that set it up:
	/// The thread for ContactThreading::OwnThread. False when it runs already or cannot be started.
	bool startContactThread();
	void stopContactThread() noexcept;
	/// One answer of that thread on the caller's, for virtual time. False when nothing was asked.
	bool serveContacts() noexcept;

	// Thread of the world:
	/// Before the hand is shown a body with this tree, lest a tick or the contact thread allocate. BulletWorldCoupling does it when a body
	/// comes near; at load time it spares the step of that. O(leaves), where no larger tree came before.
	void reserve(const ist::InnerSphereTree& tree);
	[[deprecated("since 0.3: reserve")]] void makeRoom(const ist::InnerSphereTree& tree) { reserve(tree); }
	WorldMirror& mirror() noexcept { return m_mirror; }
	btRigidBody& tool() noexcept { return m_tool; }
	const std::shared_ptr<const ist::InnerSphereTree>& toolTree() const noexcept { return m_tree; }
	const BulletDecoupledSettings& settings() const noexcept { return m_settings; }

	// Between ticks, for those who keep the books:
	/// All that contacts have given to the tool, in Bullet's World [N s].
	const ist::Vec3& receivedImpulse() const noexcept { return m_local.given(); }
	/// The ledger: what the tool has given to bodies and the world, as far as is known here, has not taken yet [N s].
	ist::Vec3 undelivered() const noexcept;
	/// In W.
	ToolState toolState() const noexcept;

	// On the tick, or between ticks: what the last one felt, in Bullet's World.
	int touchingCount() const noexcept { return m_touchingCount; }
	/// A patch, the tool being A, as far as it counted.
	const LinearContact& touching(int i) const noexcept { return m_touching[i]; }
	/// The btCollisionObject that it is with; null when that was forgotten.
	const void* touched(int i) const noexcept { return m_mirror.snapshot().bodies[m_touching[i].b].id; }
	/// Of the newest answer that the tick has seen (ContactThreading::OwnThread).
	ContactAnswerCost lastAnswer() const noexcept { return m_answers.readable().cost; }
	/// Where the copy of a body is; false, and nothing done, when it is not near.
	bool copyOf(const void* object, ist::Pose& X_WB) const noexcept;

private:
	struct Question
	{
		std::uint64_t number = 0;  // 0: none; it took the place of one that was taken back
		std::int64_t askedAt = 0;  // [ns]
		ist::Pose X_WT;
		MirroredBody bodies[kMirroredBodies];  // with the poses of the copies
	};
	struct Answer
	{
		std::uint64_t number = 0;
		std::int64_t askedAt = 0;
		LinearContact contacts[kToolContacts];
		int count = 0;
		double volume = 0, microseconds = 0;
		ContactAnswerCost cost;
		std::uint64_t coarsened = 0, overBudget = 0, refused = 0;
	};

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
	void takeModel(const LinearContact* contacts, int count, double factor) noexcept;
	void weighContacts(double dt, double factor) noexcept;
	void fill(double dt, const ist::Vec3& origin, ToolStep& step) const noexcept;
	void post() noexcept;
	bool mayRelease(int slot) const noexcept;

	btRigidBody& m_tool;
	std::shared_ptr<const ist::InnerSphereTree> m_tree;
	SteadyTime m_time;
	BulletDecoupledSettings m_settings;
	AdaptiveCoupling m_coupling;
	ist::Pose m_X_WB;
	double m_leastInertia = 0;
	const char* m_refusal;
	ist::Vec3 m_weight;  // of the tool, in World, as far as the hand is to feel it [N]
	std::atomic<ContactThreading> m_topology;

	WorldMirror m_mirror;
	ModelAge m_worldAge, m_answerAge;
	BulletLocalWorld m_local;
	BulletToolContacts m_finder;
	LinearContact m_touching[kToolContacts];
	int m_touchingCount = 0;
	std::uint64_t m_tick = 0, m_toolAnswers = 0;
	ContactThreading m_lastTopology;

	TripleBuffer<Question> m_questions;
	TripleBuffer<Answer> m_answers;
	BulletToolContacts m_threadFinder;
	double m_threadTime = -1;                            // when the last answer was published; negative: none yet on this thread
	std::uint64_t m_asked = 0, m_settled = 0;            // newest question, and newest of those that were answered or taken back
	std::uint64_t m_lastQuestion[kMirroredBodies] = {};  // that points to the tree of the slot
	bool m_triedToTakeBack = false;
	std::atomic<bool> m_contactRealTime{false};

	std::atomic<std::uint64_t> m_worldSteps{0}, m_modelAnswers{0}, m_fadedTicks{0}, m_coarsened{0}, m_overBudget{0}, m_refused{0};
	std::atomic<std::uint64_t> m_brokenSteps{0};
	std::atomic<std::int64_t> m_age{0}, m_longestAge{0}, m_period{0};
	AnsweringThread m_thread;
};
}  // namespace devicebridge
