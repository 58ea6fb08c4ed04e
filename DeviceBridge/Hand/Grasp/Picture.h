// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace devicebridge
{
/// A picture: rows from the top, three bytes per pixel, sRGB.
struct Picture
{
	int width = 0, height = 0;
	std::vector<std::uint8_t> pixels;
};

/// A grey picture: rows from the top, one number per pixel, linear in the value shown.
struct GreyPicture
{
	int width = 0, height = 0;
	std::vector<std::uint16_t> pixels;
};

/// Saves the whole PNG or none. A build without libpng refuses, too.
std::optional<ist::Error> savePicture(const Picture& picture, const std::string& path);
/// Saves a PNG with 16 bits per pixel, marked as linear.
std::optional<ist::Error> savePicture(const GreyPicture& picture, const std::string& path);
/// Loads any PNG; transparent pixels become black.
ist::Result<Picture> loadPicture(const std::string& path);
/// Loads any PNG as 16 linear bits. Pictures of savePicture keep all their bits.
ist::Result<GreyPicture> loadGreyPicture(const std::string& path);
}  // namespace devicebridge
