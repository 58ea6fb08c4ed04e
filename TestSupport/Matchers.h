// SPDX-License-Identifier: Zlib
#pragma once

#include "TestSupport/TestScenes.h"
#include "TestSupport/TestWorld.h"

#include <gmock/gmock.h>

// What a game's tests say of a TestWorld, or of one of its bodies, with EXPECT_THAT. Accounts begin at the last TestWorld::mark. Each fails
// on what is not a number.
namespace ist::test
{
/// A body, or every body of a world, moves nowhere faster than `metresPerSecond`.
MATCHER_P(IsAtRest, metresPerSecond, "")
{
	const double fastest = speed(arg);
	*result_listener << "whose fastest point moves at " << fastest << " m/s";
	return fastest <= metresPerSecond;
}
inline auto IsAtRest() { return IsAtRest(1e-3); }

/// No more than so many joules came from nowhere: TestWorld::energyGained.
MATCHER_P(GainsNoEnergy, joules, "")
{
	const double gained = arg.energyGained();
	*result_listener << "which gained " << gained << " J";
	return gained <= joules;
}

/// No more than so many newton seconds came from nowhere: TestWorld::momentumFromNowhere.
MATCHER_P(ConservesMomentum, newtonSeconds, "")
{
	const double missing = norm(arg.momentumFromNowhere());
	*result_listener << "whose momentum is " << missing << " N s off";
	return missing <= newtonSeconds;
}

/// Nothing was ever deeper in something else: ContactRecord::depth.
MATCHER_P(PenetratesAtMost, metres, "")
{
	const double deepest = arg.log().deepest();
	*result_listener << "with a contact " << deepest << " m deep";
	return deepest <= metres;
}

/// No pair slid along each other further than that in all: ContactLog::slip.
MATCHER_P(SlipsAtMost, metres, "")
{
	const double way = arg.log().slip();
	*result_listener << "with a pair that slid " << way << " m";
	return way <= metres;
}

/// What a scene measured is what theory says, up to that share of it: SceneValue::error.
MATCHER_P(AgreesWithTheory, share, "")
{
	bool agrees = !arg.empty();
	for (const SceneValue& value : arg)
		if (!(value.error() <= share))
		{
			*result_listener << (agrees ? "" : "; ") << value;
			agrees = false;
		}
	return agrees;
}
}  // namespace ist::test
