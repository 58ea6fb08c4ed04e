// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/DeviceAddress.h"

#include <algorithm>
#include <charconv>

namespace devicebridge
{
namespace
{
bool isKeyCharacter(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; }

/// Reads a list of pairs. Returns false, with `options` in any state, if `text` is not such a list.
bool readPairs(const std::string& text, std::map<std::string, std::string>& options)
{
	std::size_t at = 0;
	while (at <= text.size())
	{
		const std::size_t end = std::min(text.find('&', at), text.size());
		const std::string pair = text.substr(at, end - at);
		const std::size_t sign = pair.find('=');
		if (sign == std::string::npos || sign == 0) return false;
		const std::string key = pair.substr(0, sign);
		if (!std::all_of(key.begin(), key.end(), isKeyCharacter)) return false;
		if (!options.emplace(key, pair.substr(sign + 1)).second) return false;
		at = end + 1;
	}
	return true;
}
}  // namespace

DeviceAddress::DeviceAddress(const std::string& rest) : m_path(rest)
{
	const std::size_t mark = rest.rfind('?');
	if (mark == std::string::npos) return;
	if (readPairs(rest.substr(mark + 1), m_options)) m_path = rest.substr(0, mark);
	else m_options.clear();
}

std::optional<std::string> DeviceAddress::take(const std::string& key)
{
	const auto found = m_options.find(key);
	if (found == m_options.end()) return std::nullopt;
	std::string value = found->second;
	m_options.erase(found);
	return value;
}

ist::Result<double> DeviceAddress::takeNumber(const std::string& key, double otherwise, double least, double most)
{
	const std::optional<std::string> text = take(key);
	if (!text) return otherwise;
	double value = 0;
	const char* const end = text->data() + text->size();
	const auto [stop, failure] = std::from_chars(text->data(), end, value);
	if (failure == std::errc() && stop == end && value >= least && value <= most) return value;
	const auto shortly = [](double v) {
		char digits[32];
		return std::string(digits, std::to_chars(digits, digits + sizeof digits, v).ptr);
	};
	return ist::Error{"The option " + key + "=" + *text + " must be a number from " + shortly(least) + " to " + shortly(most), false};
}

std::string DeviceAddress::rest() const
{
	std::string text = m_path;
	char sign = '?';
	for (const auto& [key, value] : m_options)
	{
		text += sign + key + "=" + value;
		sign = '&';
	}
	return text;
}

std::string DeviceAddress::leftOver() const
{
	if (m_options.empty()) return {};
	std::string names;
	for (const auto& entry : m_options) names += (names.empty() ? "" : ", ") + entry.first;
	return "This device knows no option " + names;
}

std::string howToCalibrate(const std::string& address)
{
	if (address.rfind("glove:", 0) == 0) return "run `devicebridge calibrate " + address + " -o FILE`";
	for (const char* scheme : {"sim:", "motion:", "replay:", "spnav:", "rumble:"})
		if (address.rfind(scheme, 0) == 0) return "it needs no calibration";
	return "run the calibration of its maker, or move the handle as the maker says; `devicebridge state --watch " + address +
		"` says when it is done";
}
}  // namespace devicebridge
