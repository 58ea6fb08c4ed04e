// SPDX-License-Identifier: Zlib
#pragma once

#include <functional>

namespace ist
{
/// Callback of long offline operations, always called from the thread that called the operation. `fraction` is the progress in [0, 1] of
/// the named `stage` ("import", "repair", "packing", "cells", "surface", "field", "tree", "write", "tune").
/// Return false to cancel: the operation then returns an Error with `cancelled` set and leaves nothing behind.
using Progress = std::function<bool(const char* stage, double fraction)>;
}  // namespace ist
