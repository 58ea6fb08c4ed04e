// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/AnsweringThread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

using namespace devicebridge;

namespace
{
/// A desk whose questions are numbers; the last one counts.
struct Desk
{
	std::atomic<int> asked{0}, answered{0}, begun{0}, looks{0};
	AnsweringThread thread;

	bool start()
	{
		return thread.start([this] { ++begun; },
			[this] {
				++looks;
				const int question = asked;
				if (question == answered) return false;
				answered = question;
				return true;
			});
	}
	void ask()
	{
		++asked;
		thread.wake();
	}
	bool isAnsweredWithin(std::chrono::seconds patience) const
	{
		const auto end = std::chrono::steady_clock::now() + patience;
		while (answered != asked && std::chrono::steady_clock::now() < end) std::this_thread::yield();
		return answered == asked;
	}
};
}  // namespace

TEST(AnsweringThread, NoQuestionIsLostWhereItFallsAsleep)
{
	Desk desk;
	ASSERT_TRUE(desk.start());
	for (int i = 0; i < 2000; ++i)
	{
		desk.ask();
		ASSERT_TRUE(desk.isAnsweredWithin(std::chrono::seconds(20))) << i;
	}
	EXPECT_EQ(desk.begun, 1);
}

TEST(AnsweringThread, AnswersTheLastQuestionBeforeItStops)
{
	Desk desk;
	for (int round = 1; round <= 100; ++round)
	{
		ASSERT_TRUE(desk.start());
		EXPECT_FALSE(desk.start()) << "it runs already";
		desk.ask();
		desk.thread.stop();
		EXPECT_EQ(desk.answered, round);
		EXPECT_EQ(desk.begun, round);
	}
}

TEST(AnsweringThread, SleepsWhileNothingIsAsked)
{
	Desk desk;
	ASSERT_TRUE(desk.start());
	desk.ask();
	ASSERT_TRUE(desk.isAnsweredWithin(std::chrono::seconds(20)));
	std::this_thread::sleep_for(std::chrono::milliseconds(20));
	EXPECT_LT(desk.looks, 10);
}

TEST(AnsweringThread, WithoutAThreadWakingAndStoppingDoNothing)
{
	Desk desk;
	desk.ask();
	desk.thread.stop();
	EXPECT_EQ(desk.looks, 0);
	ASSERT_TRUE(desk.start());
	EXPECT_TRUE(desk.isAnsweredWithin(std::chrono::seconds(20))) << "asked before it was there";
}
