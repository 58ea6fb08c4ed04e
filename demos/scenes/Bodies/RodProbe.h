// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace scenes
{
/// A round rod: all points within `radius` of a segment of length 2 halfLength along the z axis of its frame T.
struct RodProbe
{
	double radius = 0.010, halfLength = 0.015;  ///< [m]
};

/// A part of a path in which the hand does one thing.
struct ProbePhase
{
	std::string name;
	double begin = 0, end = 0;  ///< [s]
	bool touches = false;       ///< true: the probe should come into contact
};
}  // namespace scenes
