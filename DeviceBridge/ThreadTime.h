// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/ThreadTime.h"

namespace devicebridge
{
using ist::threadMicroseconds;
}  // namespace devicebridge
