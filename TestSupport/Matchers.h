// SPDX-License-Identifier: Zlib
#pragma once

#include "TestSupport/TestScenes.h"
#include "TestSupport/TestWorld.h"

#include <gmock/gmock.h>

// Matchers for EXPECT_THAT on a TestWorld or one of its bodies. Their accounts begin at the last TestWorld::mark. Each matcher fails on
// NaN.
namespace ist::test
{
/// The fastest point of a body, or of any body of a world, is slower than `metresPerSecond`.
MATCHER_P(IsAtRest, metresPerSecond, "")
{
	const double fastest = speed(arg);
	*result_listener << "whose fastest point moves at " << fastest << " m/s";
	return fastest <= metresPerSecond;
}
inline auto IsAtRest() { return IsAtRest(1e-3); }

/// The energy gain without a source is at most `joules`: TestWorld::energyGained.
MATCHER_P(GainsNoEnergy, joules, "")
{
	const double gained = arg.energyGained();
	*result_listener << "which gained " << gained << " J";
	return gained <= joules;
}

/// The momentum gain without a source is at most `newtonSeconds`: TestWorld::momentumFromNowhere.
MATCHER_P(ConservesMomentum, newtonSeconds, "")
{
	const double missing = norm(arg.momentumFromNowhere());
	*result_listener << "whose momentum is " << missing << " N s off";
	return missing <= newtonSeconds;
}

/// The largest depth so far is at most `metres`: ContactRecord::depth.
MATCHER_P(PenetratesAtMost, metres, "")
{
	const double deepest = arg.log().deepest();
	*result_listener << "with a contact " << deepest << " m deep";
	return deepest <= metres;
}

/// The longest total sliding path of a pair is at most `metres`: ContactLog::slip.
MATCHER_P(SlipsAtMost, metres, "")
{
	const double way = arg.log().slip();
	*result_listener << "with a pair that slid " << way << " m";
	return way <= metres;
}

/// All values of a scene agree with theory within this share of it: SceneValue::error.
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
