// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Hand/Grasp/Picture.h"

namespace browser
{
using devicebridge::loadPicture;
using devicebridge::Picture;
using devicebridge::savePicture;

/// A picture that looks the same but compresses to half the size: its channels are rounded to 6 bits.
Picture withFewerColours(const Picture& picture);

/// Similarity of two pictures, 1 for equal ones. It is the mean structural similarity (Wang, Bovik, Sheikh and Simoncelli, 2004) of
/// lightness in windows of 8 by 8. The pictures are blurred by a box of 2 by 2 first, so that rounding at edges does not count. 0 when
/// the sizes differ.
double similarity(const Picture& a, const Picture& b);
/// Similarity of the worst window: a missing object shows here, however small it is.
double worstSimilarity(const Picture& a, const Picture& b);
}  // namespace browser
