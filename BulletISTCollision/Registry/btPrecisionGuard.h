// SPDX-License-Identifier: Zlib
#pragma once

#include "LinearMath/btScalar.h"

// Functions that take only references to Bullet's vectors have the same mangled name in both precisions and would link silently.
// Each build of the library defines one of these symbols; every translation unit that includes its headers asks for its own.
#ifdef BT_USE_DOUBLE_PRECISION
extern const int btISTBuiltForScalarOfSize8;
[[gnu::used]] inline const int* const btISTNeedsScalarOfSize8 = &btISTBuiltForScalarOfSize8;
static_assert(sizeof(btScalar) == 8, "btScalar does not match BT_USE_DOUBLE_PRECISION");
#else
extern const int btISTBuiltForScalarOfSize4;
[[gnu::used]] inline const int* const btISTNeedsScalarOfSize4 = &btISTBuiltForScalarOfSize4;
static_assert(sizeof(btScalar) == 4, "btScalar does not match BT_USE_DOUBLE_PRECISION");
#endif
