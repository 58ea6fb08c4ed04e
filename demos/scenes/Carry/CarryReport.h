// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Carry/CarryRun.h"
#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
/// The same task with one hand and with two, for each kind of feedback: none, force, and force and torque.
struct CarryReportOutcome
{
	std::vector<CarryOutcome> runs;
	double strongestAllowed = 0;  ///< largest force that the coupling of a bone may exert [N]
	double weight = 0;            ///< weight of beam, nut and ring [N]

	/// True when every run carries the beam to its place, no force exceeds what the couplings exert, and two hands tilt it less than one.
	bool ok() const;
};
ist::Result<CarryReportOutcome> runCarryReport(const CarryOptions& options);

std::vector<std::vector<std::string>> summaryRows(const CarryReportOutcome& outcome);
HtmlReport makeReport(const CarryReportOutcome& outcome);
std::string makeJson(const CarryReportOutcome& outcome);
}  // namespace scenes
