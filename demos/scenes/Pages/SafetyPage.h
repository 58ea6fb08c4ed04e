// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"

#include <string>
#include <vector>

namespace scenes
{
/// What each stage of the safety chain is there for: an attack, and what of it reaches the device without the stage and with it. The device
/// bears 10 N and 0.2 N m, 2 N and 0.05 N m in the long run. Virtual time.
struct SafetyRow
{
	std::string stage, attack, quantity, unit;
	double without = 0, with = 0;
	double atMost = 0;  ///< of the quantity, for the output to be safe

	/// The stage is needed, and it is enough.
	bool ok() const { return !(without <= atMost) && with <= atMost; }
};

struct SafetyOutcome
{
	std::vector<SafetyRow> rows;  ///< in the order of the chain

	bool ok() const;
};

SafetyOutcome runSafety();

std::vector<std::vector<std::string>> summaryRows(const SafetyOutcome& outcome);
HtmlReport makeReport(const SafetyOutcome& outcome);
std::string makeJson(const SafetyOutcome& outcome);
}  // namespace scenes
