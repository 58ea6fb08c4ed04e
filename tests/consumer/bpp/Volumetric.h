// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>

class btDiscreteDynamicsWorld;

/// What the game has of us: one of these for its world. The environment chooses:
///   BPP_VOLUMETRIC=off   nothing at all; =idle: nothing is attached
///   BPP_STIFFNESS        of the bodies that get trees [Pa/m] (btContactMaterial); else what carries the weight of its pile
///   BPP_PAIR_BUDGET      most pairs of leaves that a query finds (btISTWorld::setPairBudget); else any number
///   BPP_FORCE_ERROR      error of a force that is accepted (btISTWorld::setForceError); else the leaves answer
///   BPP_KEPT_ERROR       error of a force that kept answers may add (btISTContactCache::maxError); else 0
struct Volumetric;
std::shared_ptr<Volumetric> makeVolumetric(btDiscreteDynamicsWorld& world);
/// Before a step of the world. The first one gives every GImpact mesh its tree, and waits for it.
void updateVolumetric(Volumetric* volumetric);
