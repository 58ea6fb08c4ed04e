// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/DemoSolid.h"
#include "demos/scenes/Extremes/ExtremeWorld.h"

namespace browser
{
/// A block slides from rest down a slope, in fixed steps, for half a second. Its place in closed form is a t^2 / 2 down the slope, with a =
/// g (sin - mu cos). Steps of h lead by a h t / 2.
class SlidingBlock
{
public:
	std::optional<ist::Error> prepare(const DemoOptions& options);
	/// Distance from the closed form at the end over the length of the block, in so many steps a second.
	double error(scenes::Response response, int rate) const;
	/// The distance that the formula above gives, over the length of the block.
	static double expectedError(int rate);

private:
	SolidPtr m_block;
};
}  // namespace browser
