// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/Picture.h"

#include "BulletISTCollision/Core/Asset/AtomicFile.h"

#include <png.h>

namespace devicebridge
{
namespace
{
png_image imageOf(png_uint_32 format)
{
	png_image image{};
	image.version = PNG_IMAGE_VERSION;
	image.format = format;
	return image;
}

std::optional<ist::Error> save(int width, int height, png_uint_32 format, const void* pixels, const std::string& path)
{
	png_image image = imageOf(format);
	image.width = png_uint_32(width);
	image.height = png_uint_32(height);
	png_alloc_size_t size = 0;
	if (!png_image_write_get_memory_size(image, size, 0, pixels, 0, nullptr)) return ist::Error{path + ": " + image.message};
	std::vector<std::byte> file(size);
	if (!png_image_write_to_memory(&image, file.data(), &size, 0, pixels, 0, nullptr)) return ist::Error{path + ": " + image.message};
	const ist::Result<size_t> written = ist::writeFileAtomically(path, file.data(), size);
	if (!written) return ist::Error{path + ": the picture cannot be written: " + written.error().message};
	return std::nullopt;
}

/// Loads a PNG. `pixels(image)` allocates the pixels and returns their address.
template <class Pixels> std::optional<ist::Error> load(const std::string& path, png_uint_32 format, const Pixels& pixels)
{
	png_image image = imageOf(0);
	if (!png_image_begin_read_from_file(&image, path.c_str())) return ist::Error{path + ": " + image.message};
	image.format = format;
	const png_color black{0, 0, 0};
	if (!png_image_finish_read(&image, &black, pixels(image), 0, nullptr)) return ist::Error{path + ": " + image.message};
	return std::nullopt;
}
}  // namespace

std::optional<ist::Error> savePicture(const Picture& p, const std::string& path)
{
	return save(p.width, p.height, PNG_FORMAT_RGB, p.pixels.data(), path);
}
std::optional<ist::Error> savePicture(const GreyPicture& p, const std::string& path)
{
	return save(p.width, p.height, PNG_FORMAT_LINEAR_Y, p.pixels.data(), path);
}

ist::Result<Picture> loadPicture(const std::string& path)
{
	Picture picture;
	const auto room = [&](const png_image& image) {
		picture = {int(image.width), int(image.height), std::vector<std::uint8_t>(PNG_IMAGE_SIZE(image))};
		return picture.pixels.data();
	};
	if (auto error = load(path, PNG_FORMAT_RGB, room)) return *error;
	return picture;
}

ist::Result<GreyPicture> loadGreyPicture(const std::string& path)
{
	GreyPicture picture;
	const auto room = [&](const png_image& image) {
		picture = {int(image.width), int(image.height), std::vector<std::uint16_t>(PNG_IMAGE_SIZE(image) / 2)};
		return picture.pixels.data();
	};
	if (auto error = load(path, PNG_FORMAT_LINEAR_Y, room)) return *error;
	return picture;
}
}  // namespace devicebridge
