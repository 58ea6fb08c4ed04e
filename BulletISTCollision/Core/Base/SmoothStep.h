// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Rises from 0 at t = 0 to 1 at t = 1, where its slope is zero. t is between 0 and 1.
inline double smoothStep(double t) { return t * t * (3 - 2 * t); }
}  // namespace ist
