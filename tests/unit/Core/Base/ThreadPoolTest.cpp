// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/ThreadPool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>

using namespace ist;

TEST(ThreadPool, CallsEveryIndexOnceWithAWorkerOfThePool)
{
	for (const int threads : {1, 2, 7})
	{
		ThreadPool pool(threads);
		for (int round = 0; round < 300; ++round)
		{
			const size_t count = size_t(round) * 37 % 1000, grain = 1 + size_t(round) % 9;
			std::vector<int> calls(count, 0);
			std::atomic<int> strangers{0};
			pool.run(count, grain, [&](size_t i, int worker) {
				++calls[i];
				if (worker < 0 || worker >= threads) ++strangers;
			});
			ASSERT_EQ(calls, std::vector<int>(count, 1)) << threads << " threads, round " << round;
			ASSERT_EQ(strangers, 0);
		}
	}
}

TEST(ThreadPool, NoTwoTasksOfOneWorkerOverlap)
{
	ThreadPool pool(4);
	std::atomic<int> busy[4] = {};
	std::atomic<int> overlaps{0};
	pool.run(5000, 3, [&](size_t, int worker) {
		if (busy[worker]++ != 0) ++overlaps;
		--busy[worker];
	});
	EXPECT_EQ(overlaps, 0);
}

TEST(ThreadPool, AHelperTakesAShareWhileTheCallerIsBusy)
{
	ThreadPool pool(2);
	std::atomic<bool> helped{false};
	pool.run(2, 1, [&](size_t, int worker) {
		if (worker == 1) helped = true;
		// The caller's task ends only after the pool thread's task has begun. Ten seconds without a start count as a failure.
		for (int wait = 0; wait < 10000 && !helped; ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(1));
	});
	EXPECT_TRUE(helped);
}
