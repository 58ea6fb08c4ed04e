// SPDX-License-Identifier: Zlib
#pragma once

#include <map>
#include <optional>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"

namespace devicebridge
{
/// What stands behind the scheme of a device's address: `PATH` or `PATH?key=value&key=value`. Keys are lower-case letters, digits
/// and underscores; what follows the last question mark and is not made of such pairs belongs to the path.
class DeviceAddress
{
public:
	explicit DeviceAddress(const std::string& rest);

	const std::string& path() const { return m_path; }
	/// Takes an option out.
	std::optional<std::string> take(const std::string& key);
	/// Takes a number between `least` and `most` out; `otherwise` where there is none. Independent of the locale.
	ist::Result<double> takeNumber(const std::string& key, double otherwise, double least, double most);
	/// Path and options that nobody has taken, as they were written.
	std::string rest() const;
	/// In a sentence, which options nobody has taken; empty when all are.
	std::string leftOver() const;

private:
	std::string m_path;
	std::map<std::string, std::string> m_options;
};
}  // namespace devicebridge
