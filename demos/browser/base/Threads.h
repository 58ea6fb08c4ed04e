// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

namespace browser
{
/// A right-handed screw thread about y: the radius at the angle phi about +y and the height y is
/// radius + depth sin(starts (2 pi y / lead - phi)).
struct Thread
{
	double radius = 0.02, depth = 0.004, lead = 0.03;  ///< [m]; lead: axial advance of one turn
	int starts = 1;
};

/// A rod from y = -length to 0 with the thread, and a round head on top.
ist::Mesh screw(const Thread& thread, double length, double headRadius, double headHeight);

/// A hexagonal nut, `width` [m] across its flats, from y = -height / 2 to height / 2. Its hole is the thread, wider by `clearance` [m].
ist::Mesh nut(const Thread& thread, double clearance, double width, double height);
}  // namespace browser
