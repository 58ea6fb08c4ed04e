// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/ThreadCount.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

using namespace ist;

TEST(ThreadCount, IsWhatIsAskedForWithinReason)
{
	const int most = threadCount(64);
	EXPECT_TRUE(most == 64 || most == 1) << most;  // 1 without OpenMP
	for (const int wanted : {1, 2, 7}) EXPECT_EQ(threadCount(wanted), std::min(wanted, most));
	const int processors = int(std::thread::hardware_concurrency());
	EXPECT_LE(threadCount(100'000), std::max(64, processors));
	EXPECT_GE(threadCount(0), 1);
	EXPECT_LE(threadCount(0), std::max(64, processors));
}
