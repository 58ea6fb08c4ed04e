// SPDX-License-Identifier: Zlib
#include "demos/scenes/Carry/CarryReport.h"

#include "BulletISTCollision/Json/JsonValue.h"

#include <algorithm>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kForceSlack = 1.02, kDegrees = 57.29577951308232;
constexpr Felt kAllFelt[] = {Felt::Nothing, Felt::Force, Felt::ForceAndTorque};

int freedoms(Felt felt) { return felt == Felt::Nothing ? 0 : felt == Felt::Force ? 3 : 6; }
std::string nameOf(const CarryOutcome& run)
{
	return (run.hands == 1 ? "1 hand, " : "2 hands, ") + std::to_string(freedoms(run.felt)) + " felt";
}
const char* fateOf(const CarryOutcome& run) { return !run.lifted ? "NOT LIFTED" : run.arrived ? "arrives" : "LOST ON THE WAY"; }

/// One figure of a run.
struct Column
{
	const char *name, *unit;
	double value;
	int digits;
};
std::vector<Column> columnsOf(const CarryOutcome& run)
{
	return {{"off", "mm", 1e3 * run.off, 2}, {"largest tilt", "deg", kDegrees * run.tilt, 2}, {"slip in a palm", "mm", 1e3 * run.slip, 2},
		{"turn in a palm", "deg", kDegrees * run.slipAngle, 2}, {"nut and ring slide", "mm", 1e3 * run.passengers, 2},
		{"strongest part", "N", run.peakForce, 3}, {"force on a wrist, at rest", "N", run.wristForce, 3},
		{"torque on a wrist, at rest", "N m", run.wristTorque, 3}, {"energy without a name", "mJ", 1e3 * run.energy.residual, 2}};
}

Chart chartOf(const CarryReportOutcome& o, const std::string& title, const std::string& label, double CarrySample::*value, double scale)
{
	Chart chart{title, "time [s]", label, {}};
	for (const CarryOutcome& run : o.runs)
	{
		chart.series.push_back({nameOf(run), {}, {}, {}, false});
		for (const CarrySample& sample : run.samples)
		{
			chart.series.back().x.push_back(sample.time);
			chart.series.back().y.push_back(scale * sample.*value);
		}
	}
	return chart;
}
}  // namespace

bool CarryReportOutcome::ok() const
{
	double one = 0, two = 0;
	for (const CarryOutcome& run : runs)
	{
		if (!run.ok() || run.peakForce > kForceSlack * strongestAllowed || !run.complaints.empty()) return false;
		double& tilt = run.hands == 1 ? one : two;
		tilt = std::max(tilt, run.tilt);
	}
	return two > 0 && two < one;
}

Result<CarryReportOutcome> runCarryReport(const CarryOptions& options)
{
	const auto scene = CarryScene::make(options);
	if (!scene) return scene.error();
	CarryReportOutcome outcome;
	outcome.strongestAllowed = options.hand.maxForce;
	outcome.weight = 9.81 * scene.value()->mass();
	for (const int hands : {1, 2})
		for (const Felt felt : kAllFelt)
		{
			Result<CarryOutcome> run = runCarry(*scene.value(), hands, felt);
			if (!run) return run.error();
			outcome.runs.push_back(std::move(run).value());
		}
	return outcome;
}

std::vector<std::vector<std::string>> summaryRows(const CarryReportOutcome& o)
{
	std::vector<std::vector<std::string>> rows = {{"Result", o.ok() ? "ok" : "FAILED", ""}};
	for (const CarryOutcome& run : o.runs)
	{
		rows.push_back({nameOf(run), fateOf(run), ""});
		for (const Column& c : columnsOf(run)) rows.push_back({nameOf(run) + ": " + c.name, formatNumber(c.value, c.digits), c.unit});
	}
	return rows;
}

HtmlReport makeReport(const CarryReportOutcome& o)
{
	HtmlReport report("One hand against two, three degrees of freedom against six");
	report.paragraph("A beam of 46 cm with a nut and a ring standing on it (" + formatNumber(o.weight, 3) +
		" N together, the nut heavier than the ring) is lifted by 10 cm, carried aside by 10 cm, turned "
		"by 20 degrees and put down, always by the same script: by one hand in its middle, or by a left and a right hand near its ends. "
		"What is felt, the arm of the hand yields to: nothing, as of a tracked hand; the force, as on a device of three degrees of "
		"freedom; or force and torque, as on one of six.");
	report.paragraph(
		"What this shows and what not: the arm is a mass on a spring (1.5 kg and 300 N/m, 0.01 kg m^2 and 3 N m/rad, assumed), and the "
		"script neither looks nor learns. It shows "
		"what the task asks of hands and wrists, and what reaches them. It does not show how well a person does it who feels more.");
	std::vector<std::string> head{"Freedoms that are felt", "outcome"};
	std::vector<std::vector<std::string>> table;
	for (const CarryOutcome& run : o.runs)
	{
		table.push_back({nameOf(run), fateOf(run)});
		for (const Column& c : columnsOf(run)) table.back().push_back(formatNumber(c.value, c.digits));
	}
	for (const Column& c : columnsOf({})) head.push_back(std::string(c.name) + " [" + c.unit + "]");
	report.table(head, table);
	report.chart(chartOf(o, "Angle between the beam and where the script has it", "tilt [deg]", &CarrySample::tilt, kDegrees));
	report.chart(chartOf(o, "Height of the beam", "height [mm]", &CarrySample::height, 1e3));
	report.chart(chartOf(o, "Strongest force on a part", "force [N]", &CarrySample::force, 1));
	report.chart(chartOf(o, "Torque on the wrist that bears most", "torque [N m]", &CarrySample::felt, 1));
	return report;
}

std::string makeJson(const CarryReportOutcome& o)
{
	using Json = JsonValue;
	Json json = {{"schema", 1}, {"demo", "grasp-compare"}, {"ok", o.ok()}, {"weight", o.weight}, {"runs", Json::list()}};
	for (const CarryOutcome& run : o.runs)
		json["runs"].append({{"hands", run.hands}, {"felt_freedoms", freedoms(run.felt)}, {"lifted", run.lifted}, {"arrived", run.arrived},
			{"off", run.off}, {"tilt", run.tilt}, {"slip", run.slip}, {"slip_angle", run.slipAngle}, {"passengers_slide", run.passengers},
			{"peak_force", run.peakForce}, {"wrist_force", run.wristForce}, {"wrist_torque", run.wristTorque},
			{"energy_residual", run.energy.residual}, {"complaints", run.complaints}});
	return json.dump();
}
}  // namespace scenes
