// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/bench/peers/ParetoSweep.h"

#include <string>

namespace bench
{
std::string paretoCsv(const Sweep& sweep);
/// One JSON object with "schema", "rows" and "promises".
std::string paretoJson(const Sweep& sweep);
/// One HTML file that loads nothing: how well the tolerance was met, then the fronts of each pair of bodies.
std::string paretoHtml(const Sweep& sweep);
/// The front of one pair at each overlap: error of the force against time.
std::string frontSvg(const Sweep& sweep, const std::string& pair);
}  // namespace bench
