// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace devicebridge
{
/// Rows from the top, three bytes a pixel, sRGB.
struct Picture
{
	int width = 0, height = 0;
	std::vector<std::uint8_t> pixels;
};

/// Rows from the top, one number a pixel, in proportion to what is shown.
struct GreyPicture
{
	int width = 0, height = 0;
	std::vector<std::uint16_t> pixels;
};

/// PNG, whole or not at all. Refused as well: a build without libpng.
std::optional<ist::Error> savePicture(const Picture& picture, const std::string& path);
/// With 16 bits, marked as linear.
std::optional<ist::Error> savePicture(const GreyPicture& picture, const std::string& path);
/// Any PNG; what is transparent shows black.
ist::Result<Picture> loadPicture(const std::string& path);
/// Any PNG, as 16 linear bits: those that savePicture wrote to the last one.
ist::Result<GreyPicture> loadGreyPicture(const std::string& path);
}  // namespace devicebridge
