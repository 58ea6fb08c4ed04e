// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/bench/peers/ParetoSweep.h"

#include <string>

namespace bench
{
std::string paretoCsv(const Sweep& sweep);
/// One object: "schema", "rows" and "promises".
std::string paretoJson(const Sweep& sweep);
/// One file that loads nothing: what the dial held, then the fronts of each pair of bodies.
std::string paretoHtml(const Sweep& sweep);
/// Of one pair, the front at each overlap: error of the force against time.
std::string frontSvg(const Sweep& sweep, const std::string& pair);
}  // namespace bench
