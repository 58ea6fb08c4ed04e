// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/Grasp/Picture.h"

namespace browser
{
using devicebridge::loadPicture;
using devicebridge::Picture;
using devicebridge::savePicture;

/// The same to the eye in half of the bytes: channels rounded to 6 bits.
Picture withFewerColours(const Picture& picture);

/// How alike two pictures look, 1 for the same: the mean structural similarity (Wang, Bovik, Sheikh and Simoncelli, 2004) of lightness in
/// windows of 8 by 8, on pictures blurred by a box of 2 by 2, so that rounding at the edges of things does not count. 0 when sizes differ.
double similarity(const Picture& a, const Picture& b);
/// The worst window of the same: a thing that is missing shows here, however small it is.
double worstSimilarity(const Picture& a, const Picture& b);
}  // namespace browser
