// SPDX-License-Identifier: Zlib
#include "tests/scenario/soak/SoakRun.h"

// SOAK_SEED and SOAK_SECONDS choose another run, or hours. SOAK_WORLD is the state of one world, which a failure reports.
TEST(Soak, RandomWorldsKeepTheirInvariants)
{
	const char *seed = std::getenv("SOAK_SEED"), *seconds = std::getenv("SOAK_SECONDS"), *world = std::getenv("SOAK_WORLD");
	const std::optional<uint64_t> only = world ? std::optional<uint64_t>(std::strtoull(world, nullptr, 10)) : std::nullopt;
	const soak::Tally tally = soak::run(seed ? std::strtoull(seed, nullptr, 10) : 1, seconds ? std::atof(seconds) : 300, TREE_FOLDER, only);
	std::printf("  %llu worlds, %llu steps, %llu contacts, %llu operations, %llu poisoned, %llu refusals, %llu brought back; energy at "
				"most %.1e above its start; "
				"%ld live allocations between worlds, at most %.1f MB resident\n",
		(unsigned long long)tally.worlds, (unsigned long long)tally.steps, (unsigned long long)tally.contacts,
		(unsigned long long)tally.operations, (unsigned long long)tally.poisoned, (unsigned long long)tally.refused,
		(unsigned long long)tally.broughtBack, tally.worstGain, tally.liveAfter, tally.mostResident);
	EXPECT_GT(tally.contacts, tally.steps);
}
