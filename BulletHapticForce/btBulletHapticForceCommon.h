// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/btContactLaw.h"
#include "BulletHapticForce/btContactMaterial.h"
#include "BulletHapticForce/btEnergyAudit.h"
#include "BulletHapticForce/btEnergyLaw.h"
#include "BulletHapticForce/btISTSceneReport.h"
#include "BulletHapticForce/btISTWorld.h"
#include "BulletHapticForce/btPaperLaw.h"
#include "BulletHapticForce/btVolumetricInstallation.h"
#include "BulletHapticForce/btVolumetricRows.h"
#include "BulletHapticForce/btVolumetricSolver.h"
#include "BulletISTCollision/btBulletISTCollisionCommon.h"
