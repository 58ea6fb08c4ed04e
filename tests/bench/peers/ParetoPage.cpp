// SPDX-License-Identifier: Zlib
#include "tests/bench/peers/ParetoPage.h"

#include "demos/scenes/Pages/HtmlReport.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

using scenes::Chart, scenes::ChartSeries, scenes::formatNumber;

namespace bench
{
namespace
{
using Field = std::pair<const char*, double ParetoRow::*>;
constexpr Field kFields[] = {{"overlap", &ParetoRow::overlap}, {"build_seconds", &ParetoRow::buildSeconds}, {"bytes", &ParetoRow::bytes},
	{"p50_us", &ParetoRow::p50}, {"p99_us", &ParetoRow::p99}, {"p999_us", &ParetoRow::p999}, {"pairs", &ParetoRow::pairs},
	{"volume_bias", &ParetoRow::volumeBias}, {"volume_spread", &ParetoRow::volumeSpread}, {"force_size_rms", &ParetoRow::forceSize},
	{"force_rms", &ParetoRow::force}, {"force_p95", &ParetoRow::force95}, {"direction_deg", &ParetoRow::direction},
	{"torque_rms", &ParetoRow::torque}, {"point_rms", &ParetoRow::point}, {"depth_over_gap", &ParetoRow::depthOverGap},
	{"noise_50hz", &ParetoRow::noise}, {"loop_work", &ParetoRow::loopWork}, {"rest_depth", &ParetoRow::restDepth},
	{"in_float_1km", &ParetoRow::inFloat}, {"explicit_k", &ParetoRow::explicitK}, {"implicit_step", &ParetoRow::implicitStep},
	{"z_width", &ParetoRow::zWidth}};

/// Numbers that are not finite become null, as in all JSON output.
std::string number(double value) { return std::isfinite(value) ? formatNumber(value, 6) : "null"; }

std::string percent(double share) { return formatNumber(100 * share, 3); }

/// Names of the other libraries in the sweep; their rows have no spheres.
std::vector<std::string> peersOf(const Sweep& sweep, const std::string& pair)
{
	std::vector<std::string> peers;
	for (const ParetoRow& row : sweep.rows)
		if (row.pair == pair && row.spheres == 0 && std::find(peers.begin(), peers.end(), row.estimator) == peers.end())
			peers.push_back(row.estimator);
	return peers;
}

bool isLevel(const ParetoRow& row) { return row.estimator.rfind("level", 0) == 0; }

std::vector<std::string> pairsOf(const Sweep& sweep)
{
	std::vector<std::string> pairs;
	for (const ParetoRow& row : sweep.rows)
		if (std::find(pairs.begin(), pairs.end(), row.pair) == pairs.end()) pairs.push_back(row.pair);
	return pairs;
}

std::set<double> overlapsOf(const Sweep& sweep, const std::string& pair)
{
	std::set<double> overlaps;
	for (const ParetoRow& row : sweep.rows)
		if (row.pair == pair) overlaps.insert(row.overlap);
	return overlaps;
}

/// The rows selected by `wanted` that no other row beats in both time and error, sorted by time.
template <class Wanted> std::vector<const ParetoRow*> frontOf(const Sweep& sweep, const Wanted& wanted)
{
	std::vector<const ParetoRow*> rows, front;
	for (const ParetoRow& row : sweep.rows)
		if (wanted(row)) rows.push_back(&row);
	std::sort(rows.begin(), rows.end(),
		[](const ParetoRow* a, const ParetoRow* b) { return std::pair(a->p50, a->force95) < std::pair(b->p50, b->force95); });
	for (const ParetoRow* row : rows)
		if (front.empty() || row->force95 < front.back()->force95) front.push_back(row);
	return front;
}

ChartSeries seriesOf(std::string name, const std::vector<const ParetoRow*>& rows, bool markers)
{
	ChartSeries series{std::move(name), {}, {}, {}, markers};
	for (const ParetoRow* row : rows)
	{
		series.x.push_back(row->p50);
		series.y.push_back(100 * row->force95);
	}
	return series;
}

Chart emptyChart(const std::string& title)
{
	return {title, "median time of a query [us]", "force error that 95 % stay under [%]", {}, true};
}

Chart estimatorChart(const Sweep& sweep, const std::string& pair, double overlap)
{
	Chart chart = emptyChart(pair + " at " + percent(overlap) + " % overlap");
	const auto of = [&](const std::string& begin) {
		return
			[&, begin](const ParetoRow& row) { return row.pair == pair && row.overlap == overlap && row.estimator.rfind(begin, 0) == 0; };
	};
	const auto all = [&](const std::string& begin) {
		std::vector<const ParetoRow*> rows;
		for (const ParetoRow& row : sweep.rows)
			if (of(begin)(row)) rows.push_back(&row);
		return rows;
	};
	chart.series.push_back(seriesOf("front of fixed levels", frontOf(sweep, of("level")), false));
	chart.series.push_back(seriesOf("the dial", all("dial"), true));
	chart.series.push_back(seriesOf("budget of pairs", all("budget"), true));
	chart.series.push_back(seriesOf("paper, gain fitted", all("paper"), true));
	if (const auto closed = all("closed form"); !closed.empty()) chart.series.push_back(seriesOf("closed form", closed, true));
	for (const std::string& peer : peersOf(sweep, pair)) chart.series.push_back(seriesOf(peer, all(peer), true));
	return chart;
}

void addErrorBounds(scenes::HtmlReport& page, const Sweep& sweep)
{
	page.heading("What the dial promised, and what was true");
	page.paragraph("A pose holds when its true error, against quadrature on the triangles, is below the accepted error, or below what the "
				   "answer says of itself where "
				   "even the leaves fall short. Kept: share of poses where the accepted error itself was promised. Cost is counted in "
				   "intersecting pairs.");
	std::vector<std::vector<std::string>> rows;
	for (const ErrorBoundRow& p : sweep.errorBounds)
		rows.push_back({p.pair, std::to_string(p.spheres), percent(p.error), std::to_string(p.poses), percent(p.held), percent(p.kept),
			percent(p.ofLeaves), p.ofFixed > 0 ? formatNumber(p.ofFixed, 3) : "none holds"});
	page.table({"pair", "spheres", "accepted, %", "poses", "held, %", "kept, %", "cost of the leaves', %",
				   "over the cheapest fixed level that holds"},
		rows);
}

std::string text(double value, int digits = 3) { return std::isfinite(value) ? formatNumber(value, digits) : "-"; }
std::string textPercent(double share) { return text(100 * share); }

/// The fixed level that gets below an error in the shortest time, for any number of spheres. Then the smallest error of the levels and
/// of all others.
void addCosts(scenes::HtmlReport& page, const Sweep& sweep)
{
	constexpr double kErrors[] = {0.1, 0.05, 0.02, 0.01};
	page.heading("What an error costs");
	page.paragraph(
		"Median time of the fastest level, of any number of spheres, whose force error 95 % of the poses stay under; spheres / level "
		"behind it. Last: the least error of any level, "
		"of the paper's estimator with any number of spheres, and of the best other library, with their gains fitted to these poses.");
	std::vector<std::vector<std::string>> table;
	for (const std::string& pair : pairsOf(sweep))
		for (const double overlap : overlapsOf(sweep, pair))
		{
			const auto front = [&](const auto& wanted) {
				return frontOf(sweep, [&](const ParetoRow& r) { return r.pair == pair && r.overlap == overlap && wanted(r); });
			};
			const auto least = [](const std::vector<const ParetoRow*>& rows) {
				return rows.empty() ? "-" : textPercent(rows.back()->force95);
			};
			const std::vector<const ParetoRow*> levels = front(isLevel);
			std::vector<std::string>& cells = table.emplace_back(std::vector<std::string>{pair, percent(overlap)});
			for (const double error : kErrors)
			{
				const auto found = std::find_if(levels.begin(), levels.end(), [&](const ParetoRow* r) { return r->force95 <= error; });
				cells.push_back(found == levels.end()
						? "-"
						: text((*found)->p50) + " us, " + std::to_string((*found)->spheres) + " / " + (*found)->estimator.substr(6));
			}
			cells.push_back(least(levels));
			cells.push_back(least(front([](const ParetoRow& r) { return r.estimator == "paper"; })));
			cells.push_back(least(front([](const ParetoRow& r) { return r.spheres == 0; })));
		}
	page.table({"pair", "overlap %", "10 %", "5 %", "2 %", "1 %", "least %", "paper %", "other libraries %"}, table);
}

void addBodies(scenes::HtmlReport& page, const Sweep& sweep, const std::string& pair)
{
	std::vector<std::vector<std::string>> rows;
	std::set<int> seen;
	for (const ParetoRow& row : sweep.rows)
		if (row.pair == pair && row.spheres > 0 && seen.insert(row.spheres).second)
			rows.push_back({std::to_string(row.spheres), formatNumber(row.buildSeconds, 3), formatNumber(row.bytes / 1e6, 3)});
	page.table({"spheres", "build of both [s]", "memory of both [MB]"}, rows);
}

/// The front of the fixed levels, then all other rows.
std::vector<const ParetoRow*> rowsToShow(const Sweep& sweep, const std::string& pair, double overlap)
{
	std::vector<const ParetoRow*> rows = frontOf(
		sweep, [&](const ParetoRow& r) { return r.pair == pair && r.overlap == overlap && isLevel(r); });
	for (const ParetoRow& row : sweep.rows)
		if (row.pair == pair && row.overlap == overlap && !isLevel(row)) rows.push_back(&row);
	return rows;
}

void addTables(scenes::HtmlReport& page, const Sweep& sweep, const std::string& pair, double overlap)
{
	std::vector<std::vector<std::string>> poses, paths;
	for (const ParetoRow* r : rowsToShow(sweep, pair, overlap))
	{
		const std::string spheres = r->spheres > 0 ? std::to_string(r->spheres) : "-";
		poses.push_back({r->estimator, spheres, text(r->depthOverGap), text(r->pairs, 4), text(r->p50), text(r->p99), text(r->p999),
			textPercent(r->volumeBias), textPercent(r->volumeSpread), textPercent(r->forceSize), textPercent(r->force),
			textPercent(r->force95), text(r->direction), textPercent(r->torque), textPercent(r->point)});
		paths.push_back({r->estimator, spheres, textPercent(r->noise), textPercent(r->loopWork), textPercent(r->restDepth),
			textPercent(r->inFloat), text(r->explicitK), text(1e3 * r->implicitStep), text(1e-3 * r->zWidth)});
	}
	page.table({"in single poses", "spheres", "depth / gaps", "pairs", "p50 us", "p99", "p99.9", "V bias %", "V spread %", "|F| rms %",
				   "F rms %", "F p95 %", "deg", "torque %", "point %"},
		poses);
	page.table({"on paths", "spheres", "noise over 50 Hz %", "loop work %", "rests deeper by %", "float at 1 km %", "explicit k [Pa/m]",
				   "implicit step [ms]", "Z-width [N/mm]"},
		paths);
}
}  // namespace

std::string paretoCsv(const Sweep& sweep)
{
	std::string text = "pair,estimator,spheres,poses";
	for (const Field& field : kFields) text += std::string(",") + field.first;
	text += '\n';
	for (const ParetoRow& row : sweep.rows)
	{
		text += row.pair + ",\"" + row.estimator + "\"," + std::to_string(row.spheres) + ',' + std::to_string(row.poses);
		for (const Field& field : kFields) text += ',' + number(row.*field.second);
		text += '\n';
	}
	return text;
}

std::string paretoJson(const Sweep& sweep)
{
	std::string text = "{\"schema\":1,\"rows\":[";
	for (const ParetoRow& row : sweep.rows)
	{
		if (&row != &sweep.rows.front()) text += ",\n";
		text += "{\"pair\":\"" + row.pair + "\",\"estimator\":\"" + row.estimator + "\",\"spheres\":" + std::to_string(row.spheres) +
			",\"poses\":" + std::to_string(row.poses);
		for (const Field& field : kFields) text += std::string(",\"") + field.first + "\":" + number(row.*field.second);
		text += '}';
	}
	text += "],\n\"promises\":[";
	for (const ErrorBoundRow& p : sweep.errorBounds)
	{
		if (&p != &sweep.errorBounds.front()) text += ",\n";
		text += "{\"pair\":\"" + p.pair + "\",\"spheres\":" + std::to_string(p.spheres) + ",\"poses\":" + std::to_string(p.poses) +
			",\"error\":" + number(p.error) + ",\"held\":" + number(p.held) + ",\"kept\":" + number(p.kept) +
			",\"of_promise\":" + number(p.ofErrorBound) + ",\"of_leaves\":" + number(p.ofLeaves) +
			",\"of_fixed\":" + (p.ofFixed > 0 ? number(p.ofFixed) : "null") + '}';
	}
	return text + "]}\n";
}

std::string paretoHtml(const Sweep& sweep)
{
	scenes::HtmlReport page("Speed against accuracy");
	page.paragraph("Error of the force of two bodies against the time of a query, over random poses of the same overlap; truth by "
				   "quadrature on the triangles, which shares no "
				   "code with the library. Printed by bench_pareto; times are those of one thread on a shared machine, their last digits "
				   "mean little.");
	page.paragraph(
		"Left is fast, down is true. Level 0 are the leaves, each level above it has a third of one body's. The dial chooses "
		"the level in each pose by the force error that is accepted "
		"(ist::queryWithTolerance); a budget answers with the finest level of at most so many intersecting pairs. The front of fixed "
		"levels is the best of all numbers of spheres.");
	page.paragraph("Depth / gaps: mean depth of the overlap, V over its area vector, in sums of both bodies' mean surface gaps. Noise: of "
				   "the force above 50 Hz while a body "
				   "slides by a quarter of the size in a second, 1 kHz. Loop work: on a closed circle of 1 % of the size, of the energy "
				   "that goes up and down on it. Rests deeper: "
				   "under a load of the true force, of the size; -: nothing within a tenth of the size bears it. Float at 1 km: what the "
				   "force changes by when places are rounded. "
				   "Explicit k: the largest at which explicit steps of 1 ms of 1 kg do not diverge; implicit steps of btVolumetricSolver "
				   "have no such limit, and their column is the "
				   "longest step that keeps 95 % of the speed of an impact, for a body whose weight presses it in this deep. Z-width: b / "
				   "(T/2 + t), T = 1 ms, b = 5 N s/m, t the p99.9 "
				   "of the query. Other libraries return contacts: depth times normal, summed up, with the gain that fits these poses "
				   "best, as for the paper's estimator. The dial is asked anew in each pose, "
				   "without the fading of queryAdaptive: that its levels change is in its noise.");
	addErrorBounds(page, sweep);
	addCosts(page, sweep);
	for (const std::string& pair : pairsOf(sweep))
	{
		page.heading(pair);
		addBodies(page, sweep, pair);
		for (const double overlap : overlapsOf(sweep, pair))
		{
			page.chart(estimatorChart(sweep, pair, overlap));
			addTables(page, sweep, pair, overlap);
		}
	}
	return page.text();
}

std::string frontSvg(const Sweep& sweep, const std::string& pair)
{
	Chart chart = emptyChart("error of the force against time, " + pair);
	for (const double overlap : overlapsOf(sweep, pair))
		chart.series.push_back(seriesOf(percent(overlap) + " % overlap",
			frontOf(sweep, [&](const ParetoRow& r) { return r.pair == pair && r.overlap == overlap && isLevel(r); }), false));
	return scenes::chartSvg(chart);
}
}  // namespace bench
