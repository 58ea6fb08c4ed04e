// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Carry/CarryRun.h"
#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
/// The same task with one hand and with two, each with nothing felt, the force, and force and torque.
struct CarryReportOutcome
{
	std::vector<CarryOutcome> runs;
	double strongestAllowed = 0;  ///< that the coupling of a bone exerts [N]
	double weight = 0;            ///< of beam, nut and ring [N]

	/// Every run carries the beam to its place with no force above what the couplings exert, and two hands tilt it less than one.
	bool ok() const;
};
ist::Result<CarryReportOutcome> runCarryReport(const CarryOptions& options);

std::vector<std::vector<std::string>> summaryRows(const CarryReportOutcome& outcome);
HtmlReport makeReport(const CarryReportOutcome& outcome);
std::string makeJson(const CarryReportOutcome& outcome);
}  // namespace scenes
