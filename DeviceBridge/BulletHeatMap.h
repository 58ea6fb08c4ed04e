// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/BulletHand.h"
#include "DeviceBridge/Hand/HeatMap.h"

namespace devicebridge
{
/// A map for an object that this hand is to touch: parts in the order of HandPart, with GRAB's names and labels.
std::unique_ptr<HeatMap> makeHeatMap(const HandModel& hand, ist::Mesh object);

/// Into a map of makeHeatMap, after a step of `h` [s] of the world: what the parts of the hand did to `object`. `X_BM`: of the map's mesh in the
/// object's body frame. `seconds`: for how long this step stands, `h` when every step is added. `only`: one part alone, for a share of the
/// work in each step; negative: all. Gives the force that was added, the sum of the parts' [N]. No allocation.
double addTouches(HeatMap& map, const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const ist::Pose& X_BM, double h,
				  double seconds, int only = -1) noexcept;
}  // namespace devicebridge
