// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <string>
#include <system_error>

namespace ist
{
/// `doing`: what was tried, as in "reading the file".
inline Error fileError(const std::string& path, const char* doing, const std::error_code& reason)
{
	return {"\"" + path + "\": " + doing + " failed: " + reason.message()};
}
}  // namespace ist
