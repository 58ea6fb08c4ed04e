// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/LengthUnit.h"

#include <charconv>
#include <cmath>

namespace ist
{
namespace
{
struct NamedLength
{
	std::string_view name;
	double metres;
};
constexpr NamedLength kLengths[] = {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"um", 1e-6}, {"in", 0.0254}, {"ft", 0.3048}};
}  // namespace

std::optional<double> lengthUnit(std::string_view text)
{
	for (const NamedLength& known : kLengths)
		if (known.name == text) return known.metres;
	double metres = 0;
	const char* end = text.data() + text.size();
	const std::from_chars_result read = std::from_chars(text.data(), end, metres);
	if (read.ec != std::errc() || read.ptr != end || !(metres > 0) || !std::isfinite(metres)) return std::nullopt;
	return metres;
}

std::string lengthUnitName(double metres)
{
	for (const NamedLength& known : kLengths)
		if (known.metres == metres) return std::string(known.name);
	return {};
}
}  // namespace ist
