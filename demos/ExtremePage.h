// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

#include <string>

/// The page of the extremes: a table of four columns in Markdown, on stdout.
namespace page
{
__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...);
void row(const std::string& extreme, const std::string& stock, const std::string& ours, const std::string& reference);

/// Rows of bodies that lie, slide, tumble, or meet a thin plate. `cube`: of 1 m.
void printOverlaps(const scenes::ExtremeSolid& cube);
void printRest(const scenes::ExtremeSolid& cube);
void printFriction();
void printTumbling(const scenes::ExtremeSolid& cube);
void printThinPlate();
void printNotFinite(const scenes::ExtremeSolid& cube);
/// The rows again with nothing set.
void printNothingSet(const scenes::ExtremeSolid& cube);
/// What other commands print or test.
void printElsewhere();
}  // namespace page
