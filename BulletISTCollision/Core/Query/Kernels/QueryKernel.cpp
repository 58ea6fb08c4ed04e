// SPDX-License-Identifier: Zlib
// Compiled once for each instruction set; IST_KERNEL names the table. Everything but the table has internal linkage.
#include "BulletISTCollision/Core/Query/Kernels/FaceLanes.h"
#include "BulletISTCollision/Core/Query/Kernels/PairCulling.h"
#include "BulletISTCollision/Core/Query/Kernels/PairGroups.h"
#include "BulletISTCollision/Core/Query/Kernels/PairIntegrals.h"
#include "BulletISTCollision/Core/Query/Kernels/PairList.h"
#include "BulletISTCollision/Core/Query/Kernels/PairSearch.h"

namespace ist::kernels
{
const QueryKernel IST_KERNEL{search, cull, evaluate, refine, sumGroup, joinCone, joinNearest, findFaces, sampleDepths};
}
