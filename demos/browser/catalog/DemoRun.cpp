// SPDX-License-Identifier: Zlib
#include "demos/browser/catalog/DemoRun.h"

#include "BulletISTCollision/Json/JsonValue.h"

#include <chrono>
#include <cmath>

using namespace ist;

namespace browser
{
bool DemoOutcome::ok() const
{
	for (const Figure& figure : figures)
		if (!std::isfinite(figure.value) || (complete && !figure.ok())) return false;
	return true;
}

Result<DemoOutcome> runDemo(BrowsableDemo& demo, const std::string& name, const std::string& about, const DemoRunOptions& options)
{
	DemoOutcome out;
	out.name = name;
	out.about = about;
	out.dt = options.dt > 0 ? options.dt : demo.stepSize();
	const long long whole = std::llround(std::ceil(demo.duration() / out.dt - 1e-9)), frames = options.frames >= 0 ? options.frames : whole;
	if (auto error = demo.restart()) return *error;
	const bool begins = !options.afterStep || options.afterStep(0);
	const auto start = std::chrono::steady_clock::now();
	while (begins && out.frames < frames)
	{
		demo.step(out.dt);
		++out.frames;
		if (options.afterStep && !options.afterStep(out.frames)) break;
	}
	if (out.frames > 0)
		out.stepMicroseconds = 1e6 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / double(out.frames);
	out.seconds = demo.time();
	out.complete = out.frames >= whole;
	out.figures = demo.figures();
	out.curves = demo.curves();
	out.charts = demo.charts();
	out.report = demo.report();
	out.reportJson = demo.reportJson();
	return out;
}

std::string makeJson(const DemoOutcome& o)
{
	const auto number = [](double x) { return std::isfinite(x) ? JsonValue(x) : JsonValue(nullptr); };
	JsonValue json = {{"schema", 1}, {"demo", o.name}, {"about", o.about}, {"frames", o.frames}, {"dt", o.dt}, {"seconds", o.seconds},
		{"step_us", o.stepMicroseconds}, {"complete", o.complete}, {"figures", JsonValue::list()}};
	for (const Figure& f : o.figures)
		json["figures"].append({{"name", f.name}, {"unit", f.unit}, {"value", number(f.value)}, {"expected", number(f.expected)},
			{"tolerance", f.judged() ? number(f.tolerance) : nullptr}, {"ok", f.ok()}});
	if (!o.reportJson.empty()) json["report"] = ist::parseJson(o.reportJson).value;
	json["ok"] = o.ok();
	return json.dump();
}

std::vector<std::vector<std::string>> summaryRows(const DemoOutcome& o)
{
	std::vector<std::vector<std::string>> rows;
	for (const Figure& f : o.figures)
	{
		std::string unit = f.unit;
		if (f.judged() && o.complete)
			unit += (unit.empty() ? "(" : " (") + scenes::formatNumber(f.expected, 4) + " within " + scenes::formatNumber(f.tolerance, 2) +
				(f.ok() ? ": yes)" : ": NO)");
		rows.push_back({f.name, scenes::formatNumber(f.value, 5), unit});
	}
	rows.push_back({"time of a step", scenes::formatNumber(o.stepMicroseconds, 3), "us"});
	return rows;
}

scenes::HtmlReport makeReport(const DemoOutcome& o)
{
	scenes::HtmlReport report(o.name);
	report.paragraph(o.about + ".");
	report.table({"number", "value", "unit"}, summaryRows(o));
	for (const scenes::Chart& chart : o.charts) report.chart(chart);
	for (const std::string& row : o.report) report.paragraph(row);
	for (const Curve& curve : o.curves)
	{
		if (curve.values.size() < 2) continue;
		scenes::Chart chart{curve.name, "time before the end [s]", curve.name + (curve.unit.empty() ? "" : " [" + curve.unit + "]"), {}};
		chart.series.push_back({curve.name, {}, {}, {curve.errors.begin(), curve.errors.end()}, false});
		for (size_t i = 0; i < curve.values.size(); ++i)
		{
			chart.series[0].x.push_back((double(i) - double(curve.values.size() - 1)) / 60);
			chart.series[0].y.push_back(double(curve.values[i]));
		}
		report.chart(chart);
	}
	return report;
}
}  // namespace browser
