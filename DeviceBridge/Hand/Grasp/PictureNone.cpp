// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/Picture.h"

namespace devicebridge
{
namespace
{
ist::Error refused(const std::string& path)
{
	return {path + ": this build neither reads nor writes pictures; install libpng-dev and configure it again"};
}
}  // namespace

std::optional<ist::Error> savePicture(const Picture&, const std::string& path) { return refused(path); }
std::optional<ist::Error> savePicture(const GreyPicture&, const std::string& path) { return refused(path); }
ist::Result<Picture> loadPicture(const std::string& path) { return refused(path); }
ist::Result<GreyPicture> loadGreyPicture(const std::string& path) { return refused(path); }
}  // namespace devicebridge
