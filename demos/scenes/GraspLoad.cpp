// SPDX-License-Identifier: Zlib
#include "demos/scenes/GraspLoad.h"

#include "DeviceBridge/ThreadTime.h"
#include "demos/scenes/TraceChart.h"

#include <nlohmann/json.hpp>

#include <algorithm>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr int64_t kHandSpheres = 5000, kObjectSpheres = 10000;
constexpr double kStep = 0.001, kMostRate = 1000;
constexpr double kSoftSkin = 6e6, kDeepSqueeze = 0.04;  // [Pa/m], [m]

Chart chartOf(const GraspLoad& o, const std::string& title, const std::string& label, const std::function<double(const GraspLoadTick&)>& value)
{
	Chart chart{title, "time [s]", label, {}};
	const Trace trace{o.ticks.size(), [&](size_t i) { return o.ticks[i].time; }, [&](size_t i) { return value(o.ticks[i]); }};
	chart.series.push_back(envelope(label, trace));
	return chart;
}
double rateOf(double microseconds) { return microseconds > 0 ? std::min(kMostRate, 1e6 / microseconds) : kMostRate; }
}  // namespace

double GraspLoad::quantileMicroseconds(double p) const
{
	std::vector<double> values;
	for (const GraspLoadTick& tick : ticks) values.push_back(tick.microseconds);
	return quantile(std::move(values), p);
}

bool GraspLoadOutcome::ok() const
{
	// The soft skin is there for its load; how well it holds is not asked.
	const bool touched = std::none_of(loads.begin(), loads.end(), [](const GraspLoad& load) { return load.ticks.empty(); });
	return !loads.empty() && touched && loads.front().held;
}

double GraspLoad::mostPairs() const
{
	double most = 0;
	for (const GraspLoadTick& tick : ticks) most = std::max(most, tick.pairs);
	return most;
}

int GraspLoad::mostParts() const
{
	int most = 0;
	for (const GraspLoadTick& tick : ticks) most = std::max(most, tick.parts);
	return most;
}

namespace
{
Result<GraspLoad> runLoad(const std::string& name, const GraspOptions& grasp)
{
	const auto scene = GraspScene::make(grasp);
	if (!scene) return scene.error();
	GraspScene& s = *scene.value();
	const auto map = s.makeHeatMap();
	GraspLoad out;
	out.name = name;
	out.objectSpheres = s.objectTree()->spheres.size();
	for (const HandModel::Part& part : s.hand().model().parts) out.handSpheres += part.tree->spheres.size();
	out.step = grasp.step;
	for (int tick = 0; s.time() < GraspMotion::kShaken; ++tick)
	{
		GraspLoadTick now;
		const double begin = threadMicroseconds();
		s.step();
		const double stepped = threadMicroseconds();
		s.addTouches(*map, kHandParts, tick % kHandParts);
		const double end = threadMicroseconds();
		const BulletHand::Touch touch = s.hand().touch(grasp.step, &s.body());
		now.time = s.time();
		now.microseconds = end - begin;
		now.mapMicroseconds = end - stepped;
		now.pairs = double(touch.pairs);
		now.parts = touch.parts;
		if (touch.pairs > 0) out.ticks.push_back(now);
	}
	out.held = s.X_WM().translation.y > 0.02;
	return out;
}

}  // namespace

Result<GraspLoadOutcome> runGraspLoad(const GraspLoadOptions& options)
{
	GraspOptions grasp = options.grasp;
	if (!options.light)
	{
		grasp.handSpheres = kHandSpheres;
		grasp.objectSpheres = kObjectSpheres;
		grasp.step = kStep;
	}
	GraspOptions deep = grasp;
	deep.hand.skin.stiffness = kSoftSkin;
	deep.squeeze = kDeepSqueeze;
	GraspLoadOutcome outcome;
	for (const auto& [name, load] : {std::pair{"firm skin", grasp}, {"soft skin", deep}})
	{
		Result<GraspLoad> ran = runLoad(name, load);
		if (!ran) return ran.error();
		outcome.loads.push_back(std::move(ran).value());
	}
	return outcome;
}

namespace
{
void addRows(const GraspLoad& o, std::vector<std::vector<std::string>>& rows)
{
	std::vector<double> maps;
	for (const GraspLoadTick& tick : o.ticks) maps.push_back(tick.mapMicroseconds);
	const auto add = [&](const char* what, const std::string& value, const char* unit) { rows.push_back({o.name + ": " + what, value, unit}); };
	add("spheres of the hand", std::to_string(o.handSpheres), "");
	add("spheres of the object", std::to_string(o.objectSpheres), "");
	add("ticks with contact", std::to_string(o.ticks.size()), "");
	add("held at the end of shaking", o.held ? "yes" : "no", "");
	add("most pairs", formatNumber(o.mostPairs(), 5), "");
	add("most parts in contact", std::to_string(o.mostParts()), "");
	add("time of a tick, median", formatNumber(o.quantileMicroseconds(0.5), 4), "us");
	add("99th percentile", formatNumber(o.quantileMicroseconds(0.99), 4), "us");
	add("longest", formatNumber(o.quantileMicroseconds(1), 4), "us");
	add("heat map, 99th percentile", formatNumber(quantile(maps, 0.99), 4), "us");
	add("rate at the 99th percentile, 1000 Hz at most", formatNumber(rateOf(o.quantileMicroseconds(0.99)), 4), "Hz");
}
}  // namespace

std::vector<std::vector<std::string>> summaryRows(const GraspLoadOutcome& outcome)
{
	std::vector<std::vector<std::string>> rows;
	for (const GraspLoad& load : outcome.loads) addRows(load, rows);
	return rows;
}

HtmlReport makeReport(const GraspLoadOutcome& outcome)
{
	HtmlReport report("The load of a grasp");
	report.paragraph("Contact, response and heat map in every tick, by one thread; ticks with contact only. The time is the processor's, of that thread; the rate is "
					 "its inverse, capped at 1000 Hz.");
	report.table({"Quantity", "Value", "Unit"}, summaryRows(outcome));
	for (const GraspLoad& o : outcome.loads)
	{
		report.heading(o.name);
		report.chart(chartOf(o, "Intersecting pairs", "pairs", [](const GraspLoadTick& t) { return t.pairs; }));
		report.chart(chartOf(o, "Parts in contact with the object", "parts", [](const GraspLoadTick& t) { return double(t.parts); }));
		report.chart(chartOf(o, "Rate", "rate [Hz]", [](const GraspLoadTick& t) { return rateOf(t.microseconds); }));
	}
	return report;
}

std::string makeJson(const GraspLoadOutcome& outcome)
{
	using Json = nlohmann::ordered_json;
	Json json = {{"schema", 1}, {"demo", "grasp-load"}, {"loads", Json::array()}};
	for (const GraspLoad& o : outcome.loads)
	{
		json["loads"].push_back({{"name", o.name}, {"hand_spheres", o.handSpheres}, {"object_spheres", o.objectSpheres}, {"ticks", o.ticks.size()}, {"most_pairs", o.mostPairs()},
								 {"most_parts", o.mostParts()}, {"median_us", o.quantileMicroseconds(0.5)}, {"p99_us", o.quantileMicroseconds(0.99)},
								 {"max_us", o.quantileMicroseconds(1)}, {"held", o.held}});
	}
	json["ok"] = outcome.ok();
	return json.dump();
}
}  // namespace scenes
