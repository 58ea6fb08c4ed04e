// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/ThreadTime.h"

namespace devicebridge
{
using ist::threadMicroseconds;
}  // namespace devicebridge
