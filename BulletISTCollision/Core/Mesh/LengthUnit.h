// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// Metres per unit of length: "m", "cm", "mm", "um", "in", "ft", or a positive number of metres. Empty optional for other texts. The
/// result does not depend on the locale.
std::optional<double> lengthUnit(std::string_view text);

/// The name of a unit that lengthUnit() knows by name; empty for other lengths.
std::string lengthUnitName(double metres);
}  // namespace ist
