// SPDX-License-Identifier: Zlib
// Tests of the contact cache in the demos, against the same demos without it.
#include "demos/browser/catalog/DemoRun.h"
#include "demos/browser/catalog/KeptCheck.h"
#include "tests/EachDemo.h"

#include <string>

using namespace browser;

namespace
{
std::unique_ptr<WorldDemo> prepared(const DemoEntry& entry, const ContactCacheChoice& contactCache)
{
	std::unique_ptr<BrowsableDemo> demo = entry.make();
	DemoOptions options;
	options.cache = TREE_FOLDER;
	demo->setContactCache(contactCache);
	if (const auto failed = demo->prepare(options)) ADD_FAILURE() << failed->message;
	return std::unique_ptr<WorldDemo>(dynamic_cast<WorldDemo*>(demo.release()));
}

btISTQueryCost costOf(const WorldDemo& demo)
{
	btISTQueryCost sum;
	for (DemoWorld* world : demo.worlds())
		if (world->volumetric())
			sum.asked += world->volumetric()->contacts().cost().asked, sum.cachedMoved += world->volumetric()->contacts().cost().cached();
	return sum;
}

/// Bits of all poses and velocities.
std::vector<unsigned char> stateOf(const WorldDemo& demo)
{
	std::vector<unsigned char> bits;
	const auto append = [&](const btVector3& v) {
		const btScalar numbers[3] = {v.x(), v.y(), v.z()};
		const auto* bytes = reinterpret_cast<const unsigned char*>(numbers);
		bits.insert(bits.end(), bytes, bytes + sizeof numbers);
	};
	for (DemoWorld* world : demo.worlds())
		for (const DemoWorld::Body& b : world->bodies())
		{
			append(b.body->getWorldTransform().getOrigin());
			for (int i = 0; i < 3; ++i) append(b.body->getWorldTransform().getBasis()[i]);
			append(b.body->getLinearVelocity());
			append(b.body->getAngularVelocity());
		}
	return bits;
}
}  // namespace

class DemoContactCache : public testing::TestWithParam<DemoEntry>
{};

TEST_P(DemoContactCache, KeepsWhatItPromisesInEveryStep)
{
	constexpr double kErrorBound = 0.05;
	const auto demo = prepared(GetParam(), {true, kErrorBound});
	KeptCheck check;
	DemoRunOptions options;
	options.afterStep = [&](long long) {
		for (DemoWorld* world : demo->worlds())
			if (world->volumetric()) check.look(*world->volumetric());
		return true;
	};
	const auto outcome = runDemo(*demo, GetParam().name, GetParam().about, options);
	ASSERT_TRUE(outcome);
	EXPECT_TRUE(outcome.value().ok()) << makeJson(outcome.value());
	// The teeth of the gears touch so shallowly that each step moves them by more than the error allows.
	if (std::string(GetParam().name) != "gears")
	{
		EXPECT_GT(check.kept, 0);
	}
	EXPECT_EQ(check.missed, 0);
	const double usual = check.share(0.95), worst = check.largest();
	EXPECT_LE(usual, 0.5 * kErrorBound);
	EXPECT_LE(worst, kErrorBound);
	const btISTQueryCost cost = costOf(*demo);
	std::printf("  %llu queries, %llu kept (%.3g steps a query); error of the kept forces 95 %%: %.2g, largest %.2g\n",
		static_cast<unsigned long long>(cost.asked), static_cast<unsigned long long>(cost.cached()), cost.factor(), usual, worst);
}

TEST_P(DemoContactCache, WithoutAnErrorChangesNoBit)
{
	const auto always = prepared(GetParam(), {false, 0}), exact = prepared(GetParam(), {true, 0});
	ASSERT_FALSE(always->restart());
	ASSERT_FALSE(exact->restart());
	KeptCheck check;
	for (double t = 0; t < 1.5; t += always->stepSize())
	{
		always->step(always->stepSize());
		exact->step(exact->stepSize());
		for (DemoWorld* world : exact->worlds())
			if (world->volumetric()) check.look(*world->volumetric());
		ASSERT_EQ(stateOf(*always), stateOf(*exact)) << "after " << t << " s";
	}
	EXPECT_EQ(check.changed, 0);
	EXPECT_EQ(check.missed, 0);
	EXPECT_EQ(costOf(*always).cached(), 0u);
	EXPECT_EQ(costOf(*always).asked, costOf(*exact).asked + costOf(*exact).cached());
}
INSTANTIATE_TEST_SUITE_P(Demos, DemoContactCache, testing::ValuesIn(demosWithWorlds()), testNameOf);
