// SPDX-License-Identifier: Zlib
// What happens to the bodies of a copy when they leave while the hand's questions are answered in one way or another.
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

using namespace devicebridge;

namespace
{
/// Ways in which the questions of ContactThreading::OwnThread are answered.
enum class Served
{
	Never,         ///< no thread was started
	InTheTest,     ///< answers in the test's thread, after each tick
	ByItsThread,   ///< answers by the thread of startContactThread()
	UntilStopped,  ///< answers by that thread until it was stopped
	Count
};
const char* const kServed[] = {"never served", "served in the test", "served by its thread", "its thread was stopped"};

/// A hand at rest that overlaps a static box. Only the registry and the mirror own the box's tree.
struct LeavingRig
{
	DecoupledRig rig{240};
	btBoxShape shape{rig.boxShape};
	std::shared_ptr<const ist::InnerSphereTree> tree{new ist::InnerSphereTree(*boxTree())};
	btISTAttachment attached = std::move(rig.world.attach(&shape, tree)).value();
	btRigidBody* box = rig.add(shape, 0, {100, 2, -3});
	Hand* hand = nullptr;
	Served served;

	LeavingRig(ContactThreading topology, Served how) : served(how)
	{
		BulletDecoupledSettings settings = handSettings();
		settings.topology = topology;
		settings.realTime = false;
		hand = &rig.addHand({100, 2 + 0.035, -3}, settings);
		rig.serving = served == Served::InTheTest;
		const bool threaded = served == Served::ByItsThread || served == Served::UntilStopped;
		if (threaded && !hand->source.startContactThread()) throw std::runtime_error("no thread");
	}
	~LeavingRig() { hand->source.stopContactThread(); }
	/// Waits for a condition. A real thread runs in real time, so this may take some seconds.
	template <class Condition> bool within(int ticks, Condition condition)
	{
		rig.run(1e-3 * ticks);
		for (int i = 0; i < 5000 && served == Served::ByItsThread && !condition(); ++i)
		{
			std::this_thread::sleep_for(std::chrono::milliseconds(1));
			rig.run(1e-3);
		}
		return condition();
	}
	/// The box comes, the hand switches to `to`, and the box leaves.
	void round(ContactThreading to)
	{
		const long before = tree.use_count();
		rig.run(0.05);
		ASSERT_EQ(tree.use_count(), before + 1) << "the hand holds it";
		if (served == Served::UntilStopped) hand->source.stopContactThread();
		rig.run(0.005);
		hand->source.setTopology(to);
		rig.run(0.005);
		rig.coupling.forget(box);
		rig.world.bullet().removeRigidBody(box);
		EXPECT_TRUE(within(50, [&] { return tree.use_count() == before; })) << tree.use_count() - before;
		EXPECT_EQ(rig.coupling.crowded(), 0U);
		rig.world.bullet().addRigidBody(box);
		if (served == Served::UntilStopped)
		{
			EXPECT_TRUE(hand->source.startContactThread());
		}
	}
};
}  // namespace

// A question that will never be answered must not keep the bodies in it.
TEST(DecoupledLeaving, ABodyThatLeavesIsReleasedInEveryTopologyAndWithoutAThread)
{
	for (const ContactThreading from : kTopologies)
		for (const ContactThreading to : kTopologies)
			for (int served = 0; served < static_cast<int>(Served::Count); ++served)
			{
				SCOPED_TRACE(std::string(nameOf(from)) + ", then " + nameOf(to) + ", " + kServed[served]);
				LeavingRig r(from, static_cast<Served>(served));
				r.round(to);
			}
}

// The number of switches exceeds the number of slots for bodies.
TEST(DecoupledLeaving, AHandThatSwitchesForEverKeepsItsSlots)
{
	for (int served = 0; served < static_cast<int>(Served::Count); ++served)
	{
		SCOPED_TRACE(kServed[served]);
		LeavingRig r(ContactThreading::OwnThread, static_cast<Served>(served));
		for (int i = 1; i <= 2 * kMirroredBodies && !testing::Test::HasFatalFailure(); ++i) r.round(kTopologies[i % 3]);
	}
}

// After a question was withdrawn, a thread that is started later answers the next one.
TEST(DecoupledLeaving, AThreadThatComesLateIsAskedAnew)
{
	LeavingRig r(ContactThreading::OwnThread, Served::Never);
	for (int i = 0; i < 3; ++i) r.round(kTopologies[i]);
	r.hand->source.setTopology(ContactThreading::OwnThread);
	r.rig.run(0.1);
	EXPECT_EQ(r.hand->step.contactCount, 0);
	r.rig.serving = true;
	r.rig.run(0.1);
	EXPECT_EQ(r.hand->step.contactCount, 1);
	EXPECT_GT(r.hand->source.statistics().modelAnswers, 50U);
}
