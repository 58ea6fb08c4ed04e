// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactLaw.h"
#include "BulletHapticForce/Law/btContactMaterial.h"
#include "BulletHapticForce/Law/btEnergyLaw.h"
#include "BulletHapticForce/Law/btPaperLaw.h"
#include "BulletHapticForce/Solver/btVolumetricRows.h"
#include "BulletHapticForce/Solver/btVolumetricSolver.h"
#include "BulletHapticForce/World/btEnergyAudit.h"
#include "BulletHapticForce/World/btISTSceneReport.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletHapticForce/World/btVolumetricInstallation.h"
#include "BulletISTCollision/btBulletISTCollisionCommon.h"
