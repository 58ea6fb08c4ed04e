// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/SceneReport.h"

#include "BulletISTCollision/Json/JsonValue.h"

#include <algorithm>

using namespace ist;

namespace scenes
{
namespace
{
std::string number(double value, int digits = 3) { return formatNumber(value, digits); }
std::string number(uint64_t value) { return std::to_string(value); }

std::vector<double> valuesOf(const SceneHandRun& o, double (*value)(const SceneTick&))
{
	std::vector<double> values;
	for (size_t i = 1; i < o.ticks.size(); ++i) values.push_back(value(o.ticks[i]));
	return values;
}

/// A trace without the first tick, which has no tick before it to be counted from.
Trace traceOfSteps(const SceneHandRun& o, double (*value)(const SceneTick&))
{
	const std::vector<SceneTick>& ticks = o.ticks;
	const size_t steps = ticks.empty() ? 0 : ticks.size() - 1;
	return {steps, [&ticks](size_t i) { return ticks[i + 1].time; }, [&ticks, value](size_t i) { return value(ticks[i + 1]); }};
}

double period(const SceneTick& t) { return t.period; }
double processor(const SceneTick& t) { return t.threadMicroseconds; }
double pairs(const SceneTick& t) { return static_cast<double>(std::max(t.pairs, t.answer.pairs)); }

double lastForce(const SceneHandRun& o) { return o.ticks.empty() ? 0 : norm(o.ticks.back().wrench.force); }

double mean(const std::vector<double>& values)
{
	double sum = 0;
	for (const double v : values) sum += v;
	return values.empty() ? 0 : sum / static_cast<double>(values.size());
}
}  // namespace

const char* nameOf(SceneTopology topology)
{
	switch (topology)
	{
	case SceneTopology::OneThread: return "one-thread";
	case SceneTopology::InTick: return "contact-in-tick";
	case SceneTopology::ContactThread: return "contact-thread";
	case SceneTopology::ForceThread: return "force-thread";
	case SceneTopology::LocalModel: return "local-model";
	}
	return "";
}

Trace traceOf(const SceneHandRun& o, std::function<double(const SceneTick&)> value)
{
	const std::vector<SceneTick>& ticks = o.ticks;
	return {ticks.size(), [&ticks](size_t i) { return ticks[i].time; }, [&ticks, value](size_t i) { return value(ticks[i]); }};
}

namespace
{
/// Rows of one hand. `of` names it, where there are several.
void addRows(const SceneOutcome& o, const SceneHandRun& hand, const std::string& of, std::vector<std::vector<std::string>>& rows)
{
	const std::vector<double> periods = valuesOf(hand, period);
	rows.push_back({of + "Device", hand.device, ""});
	rows.push_back({of + "Ticks", number(uint64_t(hand.ticks.size())), ""});
	rows.push_back({of + "Force on the hand, largest", number(hand.maxForce), "N"});
	rows.push_back({of + "Force on the hand, at the end", number(lastForce(hand)), "N"});
	rows.push_back({of + "Intersecting pairs, most", number(quantile(valuesOf(hand, pairs), 1), 6), ""});
	if (!o.virtualTime)
	{
		rows.push_back({of + "Rate, mean", number(1 / std::max(1e-9, mean(periods)), 4), "Hz"});
		rows.push_back({of + "Period, median", number(1e3 * quantile(periods, 0.5)), "ms"});
		rows.push_back({of + "Period, 99.9th percentile", number(1e3 * quantile(periods, 0.999)), "ms"});
		const bool shared = o.hands.size() > 1 && o.scene.topology == SceneTopology::OneThread;
		const std::string tick = of + "Processor time of a tick" + (shared ? " of all hands" : "");
		rows.push_back({tick + ", mean", number(mean(valuesOf(hand, processor))), "us"});
		rows.push_back({tick + ", median", number(quantile(valuesOf(hand, processor), 0.5)), "us"});
		rows.push_back({tick + ", 99.9th percentile", number(quantile(valuesOf(hand, processor), 0.999)), "us"});
		rows.push_back({of + "Overruns", number(hand.overruns), ""});
	}
	for (const SceneContactCount& c : o.counts)
	{
		if (c.hand != hand.name) continue;
		rows.push_back({of + "Contact with " + c.body + ", ticks", number(c.ticks), ""});
		rows.push_back({of + "Contact with " + c.body + ", largest force", number(c.maxForce), "N"});
		rows.push_back({of + "Contact with " + c.body + ", largest overlap", number(1e9 * c.maxVolume), "mm\xC2\xB3"});
	}
	rows.push_back({of + "Commands that the safety limits changed", number(hand.safety.total()), ""});
}

void addCharts(const SceneOutcome& o, const SceneHandRun& hand, const std::string& of, HtmlReport& report)
{
	if (hand.ticks.size() < 2) return;
	report.heading(of + "What the hand feels");
	report.chart({"Force on the hand, axes of the device", "time [s]", "force [N]",
		{envelope("x", traceOf(hand, [](const SceneTick& t) { return t.wrench.force.x; })),
			envelope("y", traceOf(hand, [](const SceneTick& t) { return t.wrench.force.y; })),
			envelope("z", traceOf(hand, [](const SceneTick& t) { return t.wrench.force.z; }))}});
	report.chart({"Torque on the hand, axes of the device", "time [s]", "torque [N mm]",
		{envelope("x", traceOf(hand, [](const SceneTick& t) { return 1e3 * t.wrench.torque.x; })),
			envelope("y", traceOf(hand, [](const SceneTick& t) { return 1e3 * t.wrench.torque.y; })),
			envelope("z", traceOf(hand, [](const SceneTick& t) { return 1e3 * t.wrench.torque.z; }))}});
	report.heading(of + "Contact");
	report.chart({"Intersecting pairs of the tool", "time [s]", "pairs", {envelope("pairs", traceOf(hand, pairs))}});
	report.chart({"Overlap of the tool", "time [s]", "volume [mm\xC2\xB3]",
		{envelope("overlap", traceOf(hand, [](const SceneTick& t) { return 1e9 * t.volume; }))}});
	if (o.virtualTime) return;
	report.heading(of + "Rate");
	report.paragraph("Scheduling: " + hand.scheduling + ". Memory: " + hand.memory + ".");
	ChartSeries rate = runningMean("mean of a column", traceOfSteps(hand, period));
	for (double& y : rate.y) y = 1 / y;
	report.chart({"Rate of the force thread", "time [s]", "rate [Hz]", {rate}});
	report.chart({"Processor time of the force thread", "time [s]", "time of a tick [\xC2\xB5s]",
		{runningMean("mean of a column", traceOfSteps(hand, processor))}});
}

std::string prefixOf(const SceneOutcome& o, const SceneHandRun& hand) { return o.hands.size() > 1 ? hand.name + ": " : ""; }

JsonValue jsonOf(const SceneOutcome& o, const SceneHandRun& hand)
{
	using Json = JsonValue;
	const std::vector<double> periods = valuesOf(hand, period);
	Json json = {{"hand", hand.name}, {"device", hand.device}, {"ticks", hand.ticks.size()}, {"max_force_n", hand.maxForce},
		{"last_force_n", lastForce(hand)}, {"max_pairs", static_cast<int64_t>(quantile(valuesOf(hand, pairs), 1))},
		{"overruns", hand.overruns}, {"device_errors", hand.deviceErrors}, {"world_steps", hand.worldSteps},
		{"refused_queries", hand.refusedQueries}, {"faulted", hand.faulted}, {"safety_changes", hand.safety.total()},
		{"memory", hand.memory}, {"scheduling", hand.scheduling}};
	json["rate_hz"] = o.virtualTime || periods.empty() ? Json() : Json(1 / mean(periods));
	json["period_p999_s"] = o.virtualTime ? Json() : Json(quantile(periods, 0.999));
	json["tick_thread_p999_us"] = o.virtualTime ? Json() : Json(quantile(valuesOf(hand, processor), 0.999));
	return json;
}
}  // namespace

std::vector<std::vector<std::string>> summaryRows(const SceneOutcome& o)
{
	std::vector<std::vector<std::string>> rows = {
		{"Result", o.ok() ? "ok" : "FAILED", ""}, {"Scene", o.scene.name, ""}, {"Topology", nameOf(o.scene.topology), ""}};
	for (const SceneHandRun& hand : o.hands) addRows(o, hand, prefixOf(o, hand), rows);
	for (const std::string& what : o.switched) rows.push_back({"Switched", what, ""});
	for (const std::string& fault : o.faults) rows.push_back({"Fault", fault, ""});
	for (const std::string& file : o.unwritten) rows.push_back({"Recording that could not be written", file, ""});
	if (o.stopped) rows.push_back({"Ended early", "by a hook", ""});
	if (o.interrupted) rows.push_back({"Ended early", "by a signal", ""});
	if (o.cutShort) rows.push_back({"Ended early", "for want of samples from the device", ""});
	return rows;
}

HtmlReport makeReport(const SceneOutcome& o)
{
	HtmlReport report("Scene: " + o.scene.name);
	if (!o.scene.about.empty()) report.paragraph(o.scene.about);
	report.table({"Quantity", "Value", "Unit"}, summaryRows(o));
	if (o.virtualTime) report.paragraph("This run was made in virtual time: there is no rate to show.");
	for (const SceneHandRun& hand : o.hands) addCharts(o, hand, prefixOf(o, hand), report);
	return report;
}

std::string makeJson(const SceneOutcome& o)
{
	using Json = JsonValue;
	Json json = {{"schema", 1}, {"scene", o.scene.name}, {"ok", o.ok()}, {"topology", nameOf(o.scene.topology)},
		{"virtual_time", o.virtualTime}, {"stopped", o.stopped}, {"interrupted", o.interrupted}, {"cut_short", o.cutShort}};
	std::vector<Json> hands;
	for (const SceneHandRun& hand : o.hands) hands.push_back(jsonOf(o, hand));
	if (!hands.empty())
		for (const auto& [name, value] : hands.front().fields()) json[name] = value;
	json["hands"] = hands;
	json["switched"] = o.switched;
	json["faults"] = o.faults;
	json["unwritten"] = o.unwritten;
	json["contacts"] = Json::list();
	for (const SceneContactCount& c : o.counts)
		json["contacts"].append(
			{{"hand", c.hand}, {"body", c.body}, {"ticks", c.ticks}, {"max_force_n", c.maxForce}, {"max_volume_m3", c.maxVolume}});
	return json.dump();
}
}  // namespace scenes
