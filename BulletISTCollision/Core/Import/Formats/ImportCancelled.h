// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

namespace ist
{
/// The error of an import that its progress function has ended.
inline Error importCancelled() { return {"the import was cancelled", true}; }
}  // namespace ist
