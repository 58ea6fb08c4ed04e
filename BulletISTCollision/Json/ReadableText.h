// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Json/JsonValue.h"

#include <string>
#include <string_view>

namespace ist
{
/// The unit of a field: "m", "N s/m". "%" stands for a share, which is printed in percent, and "B" for bytes. Empty if it has none.
using UnitOf = std::string (*)(std::string_view field);

/// An object as a table for people, with one line for each field: its name without underscores, its value, its unit. Numbers have six
/// digits. A list of objects is a table with one row each, and a list of nine or 36 numbers a matrix. The field "schema" is left out.
std::string readableText(const JsonValue& report, UnitOf unitOf);

/// The unit that ends a name of ours: "time_us" is in us, and "rate_hz" in Hz. Empty if there is none.
std::string unitAtEnd(std::string_view field);
}  // namespace ist
