// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/DemandZeroArray.h"

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/ResidentMemory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <new>
#include <utility>

using namespace ist;

namespace
{
constexpr long kMegabyte = 1 << 20;
}  // namespace

TEST(DemandZeroArray, BeginsWithZerosAndKeepsWhatIsWritten)
{
	DemandZeroArray<uint32_t> a(100000);
	ASSERT_EQ(a.size(), 100000u);
	for (size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a[i], 0u);
	a[99999] = 7;
	a.touch();
	EXPECT_EQ(a[99999], 7u);
	DemandZeroArray<uint32_t> b(std::move(a));
	EXPECT_EQ(a.size(), 0u);
	EXPECT_EQ(a.data(), nullptr);
	a = std::move(b);
	EXPECT_EQ(a[99999], 7u);
}

TEST(DemandZeroArray, AnEmptyOneTakesNothingAndATooLargeOneThrows)
{
	DemandZeroArray<char> none(0);
	none.touch();
	EXPECT_EQ(none.data(), nullptr);
	EXPECT_THROW(DemandZeroArray<char>(size_t(1) << 62), std::bad_alloc);
}

TEST(DemandZeroArray, OnlyPagesThatAreWrittenAreResident)
{
	if (!residentBytes()) GTEST_SKIP() << "the system does not say what is resident";
	const long before = *residentBytes();
	DemandZeroArray<char> a(size_t(64 * kMegabyte));
	for (size_t i = 0; i < size_t(kMegabyte); ++i) a[i] = 1;
	EXPECT_LT(*residentBytes() - before, 4 * kMegabyte);
	a.touch();
	EXPECT_GT(*residentBytes() - before, 60 * kMegabyte);
}

TEST(QueryWorkspace, TakesMemoryAsItIsUsedOrAtOnceWhenAsked)
{
	if (!residentBytes()) GTEST_SKIP() << "the system does not say what is resident";
	const long before = *residentBytes();
	QueryWorkspace workspace;
	EXPECT_LT(*residentBytes() - before, 2 * kMegabyte);
	workspace.makeResident();
	EXPECT_GT(*residentBytes() - before, 20 * kMegabyte);
}
