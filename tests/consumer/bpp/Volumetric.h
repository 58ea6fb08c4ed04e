// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>

class btDiscreteDynamicsWorld;

/// What the game has of us: one of these for its world. Nothing where the environment says BPP_VOLUMETRIC=off; BPP_VOLUMETRIC=idle attaches nothing.
struct Volumetric;
std::shared_ptr<Volumetric> makeVolumetric(btDiscreteDynamicsWorld& world);
/// Before a step of the world. The first one gives every GImpact mesh its tree, and waits for it.
void updateVolumetric(Volumetric* volumetric);
