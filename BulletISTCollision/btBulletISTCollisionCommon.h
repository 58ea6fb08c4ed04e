// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/InnerSphereTree.h"
#include "BulletISTCollision/Core/OverlapQuery.h"
#include "BulletISTCollision/Core/Pose.h"
#include "BulletISTCollision/Core/PassageBarrier.h"
#include "BulletISTCollision/Core/PressureField.h"
#include "BulletISTCollision/btISTCollisionAlgorithm.h"
#include "BulletISTCollision/btISTContactStore.h"
#include "BulletISTCollision/btISTEconomy.h"
#include "BulletISTCollision/btISTRegistry.h"
#include "BulletISTCollision/btISTShapeMesh.h"
#include "BulletISTCollision/btISTTreeSource.h"
#include "BulletISTCollision/btISTWatch.h"
#include "BulletISTCollision/btPrecisionGuard.h"
