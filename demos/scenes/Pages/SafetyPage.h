// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"

#include <string>
#include <vector>

namespace scenes
{
/// Purpose of a stage of the safety chain: an attack, and what reaches the device without the stage and with it. The device bears a peak
/// of 10 N and 0.2 N m, and 2 N and 0.05 N m continuously. Virtual time.
struct SafetyRow
{
	std::string stage, attack, quantity, unit;
	double without = 0, with = 0;
	double atMost = 0;  ///< largest value of the quantity at which the output is safe

	/// True when the stage is needed and sufficient.
	bool ok() const { return !(without <= atMost) && with <= atMost; }
};

struct SafetyOutcome
{
	std::vector<SafetyRow> rows;  ///< rows in the order of the chain

	bool ok() const;
};

SafetyOutcome runSafety();

std::vector<std::vector<std::string>> summaryRows(const SafetyOutcome& outcome);
HtmlReport makeReport(const SafetyOutcome& outcome);
std::string makeJson(const SafetyOutcome& outcome);
}  // namespace scenes
