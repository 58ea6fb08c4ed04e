// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Timing/Delegate.h"

#include <gtest/gtest.h>

#include <vector>

using devicebridge::Delegate;

namespace
{
int g_freeCalls = 0;
void freeFunction(const int&) { ++g_freeCalls; }

struct Member
{
	int sum = 0;
	void add(int v) { sum += v; }
};
}  // namespace

TEST(Delegate, ListenersRunInTheOrderOfAdding)
{
	Delegate<std::vector<int>> event;
	event.addDelegate([](std::vector<int>& v) { v.push_back(1); });
	event.addDelegate([](std::vector<int>& v) { v.push_back(2); });
	std::vector<int> order;
	event.broadcast(order);
	EXPECT_EQ(order, (std::vector<int>{1, 2}));
}

TEST(Delegate, ArgumentsArriveByReference)
{
	Delegate<const int, double> event;
	const int given = 7;
	const int* seen = nullptr;
	event.addDelegate([&](const int& a, double& b) { seen = &a, b = 3; });
	double changed = 0;
	event.broadcast(given, changed);
	EXPECT_EQ(seen, &given);
	EXPECT_EQ(changed, 3);
}

TEST(Delegate, TakesFunctionsLambdasAndMembers)
{
	Delegate<const int> event;
	Member member;
	event.addDelegate(freeFunction);
	event.addDelegate([&member](const int& v) { member.add(v); });
	g_freeCalls = 0;
	event.broadcast(5);
	EXPECT_EQ(g_freeCalls, 1);
	EXPECT_EQ(member.sum, 5);
}

TEST(Delegate, RemovedListenersHearNothing)
{
	Delegate<const int> event;
	int calls = 0;
	const auto id = event.addDelegate([&](const int&) { ++calls; });
	EXPECT_TRUE(event.removeDelegate(id));
	EXPECT_FALSE(event.removeDelegate(id));
	event.broadcast(1);
	EXPECT_EQ(calls, 0);
	EXPECT_EQ(event.size(), 0U);
}

TEST(Delegate, ListenersMayAddAndRemoveWhileHearing)
{
	Delegate<const int> event;
	int own = 0, other = 0, added = 0;
	Delegate<const int>::Id ownId = 0, otherId = 0;
	ownId = event.addDelegate([&](const int&) {
		++own;
		event.removeDelegate(ownId);
		event.removeDelegate(otherId);
		for (int i = 0; i < 100; ++i) event.addDelegate([&](const int&) { ++added; });
	});
	otherId = event.addDelegate([&](const int&) { ++other; });
	event.broadcast(1);
	EXPECT_EQ(own, 1);
	EXPECT_EQ(other, 0);
	EXPECT_EQ(added, 0);
	event.broadcast(1);
	EXPECT_EQ(own, 1);
	EXPECT_EQ(added, 100);
}
