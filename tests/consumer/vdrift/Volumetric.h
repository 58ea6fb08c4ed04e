// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>

class btDiscreteDynamicsWorld;

/// What the game has of us: one of these for its world, made after it and destroyed before it.
struct Volumetric;
std::shared_ptr<Volumetric> makeVolumetric(btDiscreteDynamicsWorld& world);
/// When all bodies are there: their hulls get trees, and it waits for them. Nothing where the environment says VDRIFT_VOLUMETRIC=idle.
void attachVolumetric(Volumetric& volumetric);
/// Before the bodies go.
void detachVolumetric(Volumetric& volumetric);
