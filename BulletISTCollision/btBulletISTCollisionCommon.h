// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactCache.h"
#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"
#include "BulletISTCollision/Registry/btISTPairFilter.h"
#include "BulletISTCollision/Registry/btISTRegistry.h"
#include "BulletISTCollision/Registry/btISTShapeMesh.h"
#include "BulletISTCollision/Registry/btISTTreeSource.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"
