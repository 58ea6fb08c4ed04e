// SPDX-License-Identifier: Zlib
#include "demos/scenes/Assembly/AssemblyReport.h"

#include "BulletISTCollision/Json/JsonValue.h"

#include <algorithm>
#include <cmath>
#include <functional>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kDegrees = 57.29577951308232;

std::string nameOf(const AssemblyCondition& condition)
{
	return (condition.hands == 1 ? "1 hand, " : "2 hands, ") + std::to_string(condition.freedoms) + " felt";
}

struct Measure
{
	const char *name, *field, *unit;
	double AssemblyTrial::*value;
	double scale;
};
constexpr Measure kMeasures[] = {{"time until assembled", "time_s", "s", &AssemblyTrial::time, 1},
	{"mean force on a hand", "mean_force_n", "N", &AssemblyTrial::meanForce, 1},
	{"largest force on a hand", "max_force_n", "N", &AssemblyTrial::maxForce, 1},
	{"largest torque on a hand", "max_torque_nm", "N m", &AssemblyTrial::maxTorque, 1},
	{"largest contact force", "max_contact_n", "N", &AssemblyTrial::maxContact, 1},
	{"angle at the end", "tilt_rad", "deg", &AssemblyTrial::tilt, kDegrees},
	{"off centre at the end", "off_centre_m", "mm", &AssemblyTrial::offCentre, 1e3}};

struct Spread
{
	double mean = 0, deviation = 0;
};
Spread spreadOf(const AssemblyCondition& condition, const Measure& measure)
{
	Spread spread;
	const auto n = static_cast<double>(condition.trials.size());
	for (const AssemblyTrial& trial : condition.trials) spread.mean += measure.scale * trial.*measure.value / n;
	for (const AssemblyTrial& trial : condition.trials)
		spread.deviation += std::pow(measure.scale * trial.*measure.value - spread.mean, 2) / std::max(1.0, n - 1);
	spread.deviation = std::sqrt(spread.deviation);
	return spread;
}

size_t countDone(const AssemblyCondition& condition)
{
	return static_cast<size_t>(
		std::count_if(condition.trials.begin(), condition.trials.end(), [](const auto& trial) { return trial.done; }));
}

std::string doneOf(const AssemblyCondition& condition)
{
	return std::to_string(countDone(condition)) + " of " + std::to_string(condition.trials.size());
}

Chart overTrials(const AssemblyOutcome& o, const Measure& measure)
{
	Chart chart{measure.name, "trial", std::string(measure.name) + " [" + measure.unit + "]", {}};
	for (const AssemblyCondition& condition : o.conditions)
	{
		ChartSeries series{nameOf(condition), {}, {}, {}, true};
		for (const AssemblyTrial& trial : condition.trials)
		{
			series.x.push_back(static_cast<double>(series.x.size() + 1));
			series.y.push_back(measure.scale * trial.*measure.value);
		}
		chart.series.push_back(std::move(series));
	}
	return chart;
}

Chart overTime(const AssemblyOutcome& o, const std::string& title, const std::string& label, double AssemblySample::*value, double scale)
{
	Chart chart{title, "time [s]", label, {}};
	for (const AssemblyCondition& condition : o.conditions)
	{
		ChartSeries series{nameOf(condition), {}, {}, {}, false};
		for (const AssemblySample& sample : condition.trials.front().samples)
		{
			series.x.push_back(sample.time);
			series.y.push_back(scale * sample.*value);
		}
		chart.series.push_back(std::move(series));
	}
	return chart;
}
}  // namespace

bool AssemblyOutcome::ok() const
{
	return std::all_of(conditions.begin(), conditions.end(), [](const AssemblyCondition& condition) {
		return countDone(condition) > 0 &&
			std::all_of(condition.trials.begin(), condition.trials.end(), [](const AssemblyTrial& trial) { return trial.sound; });
	});
}

Result<AssemblyOutcome> runAssemblyReport(const AssemblyOptions& options)
{
	Result<std::vector<AssemblyCondition>> conditions = runAssembly(options);
	if (!conditions) return conditions.error();
	return AssemblyOutcome{std::move(conditions).value(), options};
}

std::vector<std::vector<std::string>> summaryRows(const AssemblyOutcome& o)
{
	std::vector<std::vector<std::string>> rows = {{"Result", o.ok() ? "ok" : "FAILED", ""}};
	for (const AssemblyCondition& condition : o.conditions)
	{
		rows.push_back({nameOf(condition) + ": assembled", doneOf(condition), ""});
		for (const Measure& measure : kMeasures)
		{
			const Spread spread = spreadOf(condition, measure);
			rows.push_back({nameOf(condition) + ": " + measure.name,
				formatNumber(spread.mean, 3) + " +- " + formatNumber(spread.deviation, 2), measure.unit});
		}
	}
	return rows;
}

HtmlReport makeReport(const AssemblyOutcome& o)
{
	HtmlReport report("A peg and a tube: one hand against two, three degrees of freedom against six");
	report.paragraph(
		"One hand carries a peg of 19 mm into a tube with a hole of 21 mm that stands on a table; or one hand carries the peg, "
		"the other one the tube, and they meet in the air. Each hand is on a simulated sigma.7, in one Bullet world at 1 kHz. With "
		"three degrees of freedom felt the device sends forces, with six also torques; nothing else differs.");
	report.paragraph("A hand follows a script, with an error that it does not correct by looking: offsets of " +
		formatNumber(1e3 * o.options.offsetSigma, 2) + " mm and angles of " + formatNumber(kDegrees * o.options.turnSigma, 2) +
		" degrees (standard deviations along each horizontal axis, seed " + std::to_string(o.options.seed) +
		"). Trial n has the same errors in "
		"all conditions; the second hand has errors of its own. The table below has means and standard deviations over " +
		std::to_string(o.options.trials) + " trials.");
	report.paragraph(
		"What this shows and what not: the hand is a spring and a damper (300 N/m, 1 N m/rad, assumed), and yields to what it "
		"feels. It does not search, learn or give up. It shows what the task asks of hands and devices, and not how well people do it; for "
		"that, run data/studies/assembly.json with people.");
	std::vector<std::string> head{"Condition", "assembled"};
	for (const Measure& measure : kMeasures) head.push_back(std::string(measure.name) + " [" + measure.unit + "]");
	std::vector<std::vector<std::string>> table;
	for (const AssemblyCondition& condition : o.conditions)
	{
		table.push_back({nameOf(condition), doneOf(condition)});
		for (const Measure& measure : kMeasures)
		{
			const Spread spread = spreadOf(condition, measure);
			table.back().push_back(formatNumber(spread.mean, 3) + " \xC2\xB1 " + formatNumber(spread.deviation, 2));
		}
	}
	report.table(head, table);
	report.heading("Each trial");
	for (const size_t i : {0, 2, 4, 5}) report.chart(overTrials(o, kMeasures[i]));
	report.heading("The first trial");
	report.chart(overTime(o, "Depth of the peg in the tube", "depth [mm]", &AssemblySample::depth, 1e3));
	report.chart(overTime(o, "Force on the most loaded hand", "force [N]", &AssemblySample::force, 1));
	return report;
}

std::string makeJson(const AssemblyOutcome& o)
{
	using Json = JsonValue;
	Json json = {{"schema", 1}, {"demo", "assembly"}, {"ok", o.ok()}, {"seed", o.options.seed}, {"offset_sigma_m", o.options.offsetSigma},
		{"turn_sigma_rad", o.options.turnSigma}, {"conditions", Json::list()}};
	for (const AssemblyCondition& condition : o.conditions)
	{
		Json& row = json["conditions"].append({{"hands", condition.hands}, {"felt_freedoms", condition.freedoms},
			{"assembled", countDone(condition)}, {"trials", Json::list()}});
		for (const AssemblyTrial& trial : condition.trials)
		{
			Json& one = row["trials"].append({{"assembled", trial.done}, {"sound", trial.sound}});
			for (const Measure& measure : kMeasures) one[measure.field] = trial.*measure.value;
		}
	}
	return json.dump();
}
}  // namespace scenes
