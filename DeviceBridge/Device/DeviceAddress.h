// SPDX-License-Identifier: Zlib
#pragma once

#include <map>
#include <optional>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"

namespace devicebridge
{
/// The part of a device's address after the scheme: `PATH` or `PATH?key=value&key=value`. Keys are lower-case letters, digits and
/// underscores. Text after the last question mark that is not a list of such pairs belongs to the path.
class DeviceAddress
{
public:
	explicit DeviceAddress(const std::string& rest);

	const std::string& path() const { return m_path; }
	/// Removes an option and returns its value.
	std::optional<std::string> take(const std::string& key);
	/// Removes an option and returns its value as a number between `least` and `most`; `otherwise` if the option is missing. Independent of
	/// the locale.
	ist::Result<double> takeNumber(const std::string& key, double otherwise, double least, double most);
	/// The path and the options that were not taken, as they were written.
	std::string rest() const;
	/// A sentence that names the options that were not taken; empty if all were.
	std::string leftOver() const;

private:
	std::string m_path;
	std::map<std::string, std::string> m_options;
};

/// How the device at an address is calibrated, as an order to a person, or that it needs no calibration. Gloves have a command of their
/// own.
std::string howToCalibrate(const std::string& address);
}  // namespace devicebridge
