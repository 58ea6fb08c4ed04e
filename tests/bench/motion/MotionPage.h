// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"
#include "tests/bench/motion/MotionSweep.h"

namespace bench
{
/// An error in two digits; "-" where it is negative, hence not measured.
std::string shownError(double error);
/// Prints what was found of a scene.
void print(const MotionFindings& found);
/// Prints the gain of steps that are chosen in hindsight, for each scene, and its median over scenes with events.
void printGains(const std::vector<MotionFindings>& all);
/// Gain of scenes with events at the tolerance with this index, where a fixed step is within it.
struct MedianGain
{
	double median = 0;
	size_t scenes = 0;  ///< number of these scenes
};
MedianGain medianGain(const std::vector<MotionFindings>& all, size_t tolerance, double MotionGain::*gain);
/// The page docs/accuracy-of-motion.html.
scenes::HtmlReport makePage(const std::vector<MotionFindings>& all);
}  // namespace bench
