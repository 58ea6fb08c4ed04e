// SPDX-License-Identifier: Zlib
#include "demos/scenes/HapticBunny/HapticBunnyReport.h"

#include "demos/scenes/Pages/TraceChart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr double kTick = 1e-3;    // [s]
constexpr size_t kPoints = 2000;  // number of points of a curve of shares

using Value = std::function<double(const TraceSample&)>;

Trace over(const std::vector<TraceSample>& trace, const Value& value)
{
	return {trace.size(), [&trace](size_t i) { return trace[i].time; }, [&trace, value](size_t i) { return value(trace[i]); }};
}

ChartSeries envelope(const std::string& name, const std::vector<TraceSample>& trace, const Value& value)
{
	return envelope(name, over(trace, value));
}

ChartSeries errors(
	const HapticBunnyOutcome& o, const std::string& name, const std::function<std::array<double, 2>(const TraceComparison&)>& value)
{
	ChartSeries series{name, {}, {}, {}, true};
	for (const TraceComparison& c : o.comparisons)
	{
		const auto [error, sigma] = value(c);
		series.x.push_back(o.trace[c.sample].time);
		series.y.push_back(100 * error);
		series.sigma.push_back(100 * sigma);
	}
	return series;
}

ChartSeries truths(const HapticBunnyOutcome& o, const std::function<double(const TraceComparison&)>& value)
{
	ChartSeries series{"quadrature", {}, {}, {}, true};
	for (const TraceComparison& c : o.comparisons)
	{
		series.x.push_back(o.trace[c.sample].time);
		series.y.push_back(value(c));
	}
	return series;
}

std::string number(double value, int digits = 3) { return formatNumber(value, digits); }
std::string number(uint64_t value) { return std::to_string(value); }

std::string phaseSentence(const HapticBunnyOutcome& o)
{
	std::string text = "The hand: ";
	for (size_t i = 0; i < o.phases.size(); ++i)
		text += (i ? ", " : "") + o.phases[i].name + " (" + number(o.phases[i].begin) + " to " + number(o.phases[i].end) + " s)";
	return text + ".";
}

void addForceCharts(HtmlReport& report, const HapticBunnyOutcome& o)
{
	report.heading("What the hand feels");
	report.paragraph("Force and torque that the device exerts on the hand, in world axes (y is up), torque about the centre of the rod. "
					 "A press on the back pushes the hand up. A moving hand also feels the rod's inertia.");
	report.chart({"Force on the hand", "time [s]", "force [N]",
		{envelope("x", o.trace, [](const TraceSample& s) { return s.hand.force.x; }),
			envelope("y (up)", o.trace, [](const TraceSample& s) { return s.hand.force.y; }),
			envelope("z", o.trace, [](const TraceSample& s) { return s.hand.force.z; })}});
	report.chart({"Torque on the hand", "time [s]", "torque [N mm]",
		{envelope("x", o.trace, [](const TraceSample& s) { return 1e3 * s.hand.torque.x; }),
			envelope("y (up)", o.trace, [](const TraceSample& s) { return 1e3 * s.hand.torque.y; }),
			envelope("z", o.trace, [](const TraceSample& s) { return 1e3 * s.hand.torque.z; })}});
}

void addRateCharts(HtmlReport& report, const HapticBunnyOutcome& o)
{
	report.heading("Rate of the haptic loop");
	if (o.virtualTime)
	{
		report.paragraph("This run was made in virtual time: every period is exactly one millisecond, and there is no rate to show.");
		return;
	}
	report.paragraph("One over the time between two ticks. After a gap of more than one period, which the operating system makes, the loop "
					 "starts its schedule anew instead of catching up. Scheduling: " +
		o.scheduling + ".");
	std::vector<TraceSample> ticks(o.trace.begin() + 1, o.trace.end());
	const auto period = [](const TraceSample& s) { return s.period; };
	ChartSeries mean = runningMean("mean", over(ticks, period)), slowest = runningQuantile("slowest tick", over(ticks, period), 1);
	for (ChartSeries* series : {&mean, &slowest})
		for (double& y : series->y) y = 1 / y;
	report.chart({"Rate, in stretches of about thirty ticks", "time [s]", "rate [Hz]", {slowest, mean}});
	std::sort(ticks.begin(), ticks.end(), [](const auto& a, const auto& b) { return a.period < b.period; });
	ChartSeries share{"ticks", {}, {}, {}, false};
	const double longest = 2 * o.periods.p50;
	for (size_t i = 0; i < ticks.size(); i += std::max<size_t>(1, ticks.size() / kPoints))
	{
		if (ticks[i].period > longest) break;
		share.x.push_back(1e3 * ticks[i].period);
		share.y.push_back(100 * static_cast<double>(i + 1) / static_cast<double>(ticks.size()));
	}
	report.chart({"Share of ticks with at most this period, up to twice the median", "period [ms]", "share [%]", {share}});
}
}  // namespace

std::vector<std::vector<std::string>> summaryRows(const HapticBunnyOutcome& o)
{
	const std::string judged = ", rms error / rms truth of " + std::to_string(o.comparisons.size());
	const bool decoupled = o.worldRate > 0;
	std::vector<std::vector<std::string>> rows = {{"Result", o.ok() ? "ok" : "FAILED", ""},
		{"Mode", decoupled ? "decoupled" : "simple", ""}, {"Rate of the world", decoupled ? number(o.worldRate) : number(1 / kTick), "Hz"},
		{"Triangles", number(o.triangles), ""}, {"Spheres", number(o.spheres), ""}, {"Leaves", number(o.leaves), ""},
		{"Fill", number(100 * o.fill), "%"}, {o.loadedFromCache ? "Tree, loaded" : "Tree, built", number(o.buildSeconds), "s"},
		{"Mass of the body", number(o.mass), "kg"}, {"Queries of a tick, median in contact", number(o.medianQuery), "us"},
		{"Queries of a tick, 99th percentile", number(o.p99Query), "us"}, {"Intersecting pairs, most", std::to_string(o.maxPairs), ""},
		{"Rate, mean", number(o.meanRate, 4), "Hz"}, {"Period, median", number(1e3 * o.periods.p50), "ms"},
		{"Period, 99th percentile", number(1e3 * o.periods.p99), "ms"}, {"Period, 99.9th percentile", number(1e3 * o.periods.p999), "ms"},
		{"Period, longest", number(1e3 * o.periods.max), "ms"},
		{"Overruns in " + number(o.trace.size()) + " ticks", number(o.overruns), ""},
		{"Force on the hand, largest", number(o.maxForce), "N"}, {"Torque on the hand, largest", number(1e3 * o.maxTorque), "N mm"},
		{"Work of the device on the hand", number(1e3 * o.work), "mJ"}, {"Sinkage at rest", number(1e3 * o.sinkage.measured), "mm"},
		{"Sinkage predicted by the tree", number(1e3 * o.sinkage.byTree), "mm"},
		{"Sinkage predicted by the mesh", number(1e3 * o.sinkage.byMesh), "mm"},
		{"Mean gap of the packing", number(1e3 * o.sinkage.gap), "mm"}, {"Volume" + judged, number(100 * o.volumeRms, 2), "%"},
		{"Force" + judged, number(100 * o.forceRms, 2), "%"},
		{"Force, direction, median error", number(kDegrees * o.forceDirection, 2), "degrees"},
		{"Commands that the safety limits changed", number(o.safety.total()), ""}, {"Contacts dropped", number(o.droppedContacts), ""}};
	if (!decoupled) return rows;
	const DecoupledFigures& d = o.decoupled;
	rows.push_back({"Steps of the world that the hand saw", number(d.worldSteps), ""});
	rows.push_back({"Age of the world, most", number(1e3 * d.longestModelAge), "ms"});
	rows.push_back({"Ticks with a world too late", number(d.fadedTicks), ""});
	rows.push_back({"Impulse of contacts on the tool", number(norm(d.toTool)), "N s"});
	rows.push_back({"Impulse of the tool on bodies", number(norm(d.toWorld)), "N s"});
	rows.push_back({"Sum of both", number(norm(d.underWay), 2), "N s"});
	rows.push_back({"Shift of the body in the session", number(1e3 * d.bodyShift), "mm"});
	return rows;
}

HtmlReport makeReport(const HapticBunnyOutcome& o)
{
	HtmlReport report("A simulated hand feels a mesh");
	report.paragraph(
		"A closed mesh was filled with spheres and stands, as a rigid body, in a Bullet world on Bullet's own plane. A simulated "
		"hand on a simulated 6-DOF device (sigma.7) holds a steel rod, 50 mm long and 20 mm thick: it presses the rod on the "
		"back, slides it over the back and along the ear, turns it about the vertical, and lets go. " +
		std::string(o.worldRate > 0 ? "The world steps at its own rate of " + number(o.worldRate) +
					" Hz; the haptic loop moves copies of the bodies near the rod at 1 kHz, and the world gets the "
					"impulses that they got."
									: "The haptic loop steps the whole world once per tick at 1 kHz."));
	report.paragraph(phaseSentence(o));
	for (const std::string& phase : o.phasesWithoutContact) report.paragraph("No contact where it was meant: " + phase + ".");
	for (const std::string& action : o.repair) report.paragraph("Repair of the mesh: " + action);
	report.heading("Summary");
	report.table({"Quantity", "Value", "Unit"}, summaryRows(o));
	if (o.trace.size() < 2) return report;
	addForceCharts(report, o);
	addRateCharts(report, o);
	report.heading("Overlap");
	report.paragraph(
		"Overlap of rod and body, and the elastic force between them. The dots are an independent integration over the triangles "
		"of both meshes, in the poses that were recorded.");
	report.chart({"Overlap volume", "time [s]", "volume [mm\xC2\xB3]",
		{envelope("inner sphere tree", o.trace, [](const TraceSample& s) { return 1e9 * s.volume; }),
			truths(o, [](const TraceComparison& c) { return 1e9 * c.volumeTruth; })}});
	report.chart({"Elastic force between rod and body", "time [s]", "|force| [N]",
		{envelope("inner sphere tree", o.trace, [](const TraceSample& s) { return norm(s.elastic); }),
			truths(o, [](const TraceComparison& c) { return norm(c.forceTruth); })}});
	report.paragraph("Relative errors at these instants; for the force, the length of the difference of the vectors." +
		std::string(o.worldRate > 0 ? "" : " The bars are the standard errors that the library itself predicts, one sigma."));
	report.chart({"Errors against quadrature", "time [s]", "error [%]",
		{errors(o, "volume",
			 [&](const TraceComparison& c) {
				 return std::array{c.volumeError / c.volumeTruth, o.trace[c.sample].volumeSigma / c.volumeTruth};
			 }),
			errors(o, "force", [&](const TraceComparison& c) {
				return std::array{c.forceError / norm(c.forceTruth), o.trace[c.sample].forceSigma / norm(c.forceTruth)};
			})}});
	report.heading("Work");
	report.chart({"Intersecting pairs of the rod", "time [s]", "pairs",
		{envelope("pairs", o.trace, [](const TraceSample& s) { return static_cast<double>(s.pairs); })}});
	report.paragraph(
		"Queries of a tick: rod and body, and body and plane. Medians of about thirty ticks each; the table above has the 99th "
		"percentile, which contains what the operating system put in between.");
	report.chart({"Time of all queries of a tick", "time [s]", "time [\xC2\xB5s]",
		{runningQuantile("median", over(o.trace, [](const TraceSample& s) { return s.queryMicroseconds; }), 0.5)}});
	return report;
}

std::string makeJson(const HapticBunnyOutcome& o)
{
	std::string out = "{\"schema\":1,\"demo\":\"haptic-bunny\",\"ok\":" + std::string(o.ok() ? "true" : "false");
	const auto field = [&](const char* name, double value) {
		out += std::string(",\"") + name + "\":" + (std::isfinite(value) ? formatNumber(value, 9) : "null");
	};
	const auto flag = [&](const char* name, bool value) { out += std::string(",\"") + name + "\":" + (value ? "true" : "false"); };
	const auto count = [&](const char* name, uint64_t value) { out += std::string(",\"") + name + "\":" + std::to_string(value); };
	field("unit", o.unit), count("triangles", o.triangles), count("spheres", o.spheres), count("leaves", o.leaves);
	field("fill", o.fill), field("mass_kg", o.mass), field("build_s", o.buildSeconds), flag("cached", o.loadedFromCache);
	flag("virtual_time", o.virtualTime), count("ticks", o.trace.size());
	field("query_median_us", o.medianQuery), field("query_p99_us", o.p99Query), count("max_pairs", static_cast<uint64_t>(o.maxPairs));
	field("rate_hz", o.meanRate), field("period_p50_s", o.periods.p50), field("period_p99_s", o.periods.p99);
	field("period_p999_s", o.periods.p999), field("period_max_s", o.periods.max), count("overruns", o.overruns);
	count("device_errors", o.deviceErrors), field("max_force_n", o.maxForce), field("max_torque_nm", o.maxTorque), field("work_j", o.work);
	field("sinkage_m", o.sinkage.measured), field("sinkage_by_tree_m", o.sinkage.byTree), field("sinkage_by_mesh_m", o.sinkage.byMesh);
	field("mean_gap_m", o.sinkage.gap), field("pair_stiffness_pa_per_m", o.pairStiffness);
	field("volume_error_rms", o.volumeRms), field("force_error_rms", o.forceRms), field("force_direction_error_rad", o.forceDirection);
	count("safety_changes", o.safety.total()), count("safety_ramped", o.safety.ramped), count("safety_passivity", o.safety.passivity),
		flag("faulted", o.faulted), count("dropped_contacts", o.droppedContacts);
	flag("came_free", o.cameFree);
	out += std::string(",\"mode\":\"") + (o.worldRate > 0 ? "decoupled" : "simple") + "\"";
	field("world_hz", o.worldRate > 0 ? o.worldRate : 1 / kTick);
	if (o.worldRate > 0)
	{
		const DecoupledFigures& d = o.decoupled;
		count("world_steps", d.worldSteps), field("longest_model_age_s", d.longestModelAge), count("faded_ticks", d.fadedTicks);
		field("impulse_on_tool_ns", norm(d.toTool)), field("impulse_on_bodies_ns", norm(d.toWorld)),
			field("impulse_rest_ns", norm(d.underWay));
		field("body_shift_m", d.bodyShift);
	}
	out += ",\"memory\":\"" + o.memory + "\",\"scheduling\":\"" + o.scheduling + "\",\"phases_without_contact\":[";
	for (size_t i = 0; i < o.phasesWithoutContact.size(); ++i) out += (i ? ",\"" : "\"") + o.phasesWithoutContact[i] + "\"";
	return out + "]}";
}
}  // namespace scenes
