// SPDX-License-Identifier: Zlib
#include "tests/bench/motion/MotionPage.h"

#include <algorithm>
#include <cmath>

using namespace ist;
using scenes::formatNumber;

namespace bench
{
namespace
{
using Contact = MotionSettings::Contact;
using Table = std::vector<std::vector<std::string>>;

std::string hertz(int rate) { return std::to_string(rate) + " Hz"; }
std::string percent(double share) { return formatNumber(100 * share, 2) + " %"; }

/// Whether the reference of a scene can tell an error of this size.
bool canTell(const MotionFindings& f, double error) { return f.truths[0].convergence <= 0.5 * error; }

std::string errorAt(const MotionFindings& f, Contact contact, int rate)
{
	const MotionRow* row = f.row(contact, rate);
	return row ? shownError(row->error) : "-";
}

/// Median error at a rate, over the scenes that were run at it.
double medianError(const std::vector<MotionFindings>& all, Contact contact, int rate)
{
	std::vector<double> errors;
	for (const MotionFindings& f : all)
		if (const MotionRow* row = f.row(contact, rate)) errors.push_back(row->error);
	if (errors.empty()) return -1;
	std::sort(errors.begin(), errors.end());
	return 0.5 * (errors[(errors.size() - 1) / 2] + errors[errors.size() / 2]);
}

/// Number of scenes whose error at a rate is at most `tolerance`.
size_t countWithin(const std::vector<MotionFindings>& all, Contact contact, int rate, double tolerance)
{
	return size_t(std::count_if(all.begin(), all.end(), [&](const MotionFindings& f) {
		const MotionRow* row = f.row(contact, rate);
		return row && row->error <= tolerance;
	}));
}

void addSummary(scenes::HtmlReport& page, const std::vector<MotionFindings>& all)
{
	Table rows;
	for (const int rate : {60, 120, 240, 480, 960})
		rows.push_back({hertz(rate), shownError(medianError(all, Contact::Given, rate)),
			std::to_string(countWithin(all, Contact::Given, rate, 0.1)), std::to_string(countWithin(all, Contact::Given, rate, 0.01)),
			shownError(medianError(all, Contact::Default, rate)), std::to_string(countWithin(all, Contact::Default, rate, 0.1)),
			std::to_string(countWithin(all, Contact::Default, rate, 0.01))});
	page.paragraph("The motion of " + std::to_string(all.size()) +
		" scenes, compared with what it would be in steps of no length. The table has the median of the errors, as a share of the body's "
		"size, and the number of scenes within 0.1 and 0.01.");
	page.table({"steps", "materials given: median", "within 0.1", "within 0.01", "nothing set: median", "within 0.1", "within 0.01"}, rows);
	double most = 0;
	size_t pairs = 0, changed = 0;
	for (const MotionFindings& f : all)
		for (const MotionRow& r : f.rows)
			if (r.queryError >= 0 && r.settings.spheres == 0 && r.settings.rate >= 240)
				++pairs, changed += r.queryError > 0, most = std::max(most, r.queryError);
	const std::string moved = changed == 0
		? "each moves as with the finest queries, exactly."
		: std::to_string(changed) + " move otherwise than with the finest queries, by at most " + shownError(most) + " of a body.";
	page.paragraph("The tolerance of the force makes little difference to the motion. " + std::to_string(pairs) +
		" runs at 240 Hz and 960 Hz accept a force error of 5 % or 20 %: " + moved +
		" Contact of bodies that rest, slide or strike is shallow. There surfaces answer, and no coarser level would take less time.");
	size_t scenes = 0, byQueries = 0;
	for (const MotionFindings& f : all)
		if (const MotionRow* few = f.rowOfSpheres(kFewSpheres.front()), *own = f.row(Contact::Given, kSphereRate); few && own)
			++scenes, byQueries += few->queryError > own->error;
	page.paragraph("The number of spheres matters more. With trees of 100 spheres, queries err more than steps of 240 Hz in " +
		std::to_string(byQueries) + " of " + std::to_string(scenes) + " scenes in which trees meet.");
	std::string lost;
	for (const MotionFindings& f : all)
		if (const MotionRow* row = f.row(Contact::Given, 60); row && row->error > 1)
			lost += (lost.empty() ? "" : ", ") + std::string(f.entry.name);
	if (!lost.empty())
		page.paragraph(
			"With materials given, these scenes end more than the size of a body from where they should in steps of 60 Hz: " + lost + ".");
	page.paragraph("The error falls in proportion to the step, with two exceptions. Bodies that bounce lose speed to the implicit step. In "
				   "each impact about exp(-pi h omega / 2) is left, with the frequency omega of the contact, so the error is large until h "
				   "omega is small. With nothing set, contact is soft below steps of 1 ms (see below).");
}

void addMethod(scenes::HtmlReport& page, size_t scenes)
{
	page.heading("How it was measured");
	page.paragraph("The page was made by bench_motion_error-float64 && bench_motion_error --report docs/accuracy-of-motion.html, built "
				   "with -DBULLETHAPTICS_BENCH=ON. Single scenes run with --scene NAME, and an interrupted run goes on where it was.");
	page.paragraph("The error of a pose is the distance of the body's centre from its true place over the body's longest side. Half of the "
				   "angle [rad] between the two rotations is added. The error of a run is the largest of all bodies and of all "
				   "checkpoints, which are 1/30 s apart. An error of 0.01 is a hundredth of the body.");
	page.paragraph(std::to_string(scenes) +
		" scenes run in double precision in fixed steps from 30 Hz to 10 kHz, or to a sixth of the reference. Rates grow by a factor of "
		"some 1.19 from 60 Hz to 480 Hz, and of 2 elsewhere. The true motion is the limit of the same scene, with the finest queries, as "
		"the step goes to zero. It is extrapolated from two runs, at the rate of the reference and at half of it. That rate is 61,440 Hz "
		"for single bodies, a 128th of a step of 480 Hz, and 7,680 or 15,360 Hz for many. How far the limit moves when both rates are "
		"halved stands in the last table. Tolerances below twice that are left out.");
	page.paragraph("With materials given, the model is the same at all steps. With nothing set, stiffness follows a rule that knows the "
				   "step: what a contact stops within one step, and what a step bears. There, the true motion is the limit of the rule as "
				   "the step goes to zero. By what presses, the stiffness grows at most by a factor of exp((h / 10 ms)^2) in a step h. In "
				   "steps well below 1 ms it hardly grows, and bodies stay deeper than at 60 Hz for seconds. So the limit is a softer "
				   "contact, and an error against it is no defect of the larger step. The closed forms below show which motion is right.");
	page.paragraph("A motion can be foreseen only until small causes have large effects. Each scene also ran with its bodies displaced and "
				   "turned by a millionth of their size. It is judged until that difference has grown a hundredfold.");
	page.paragraph("Cost is counted in steps and queries of contact together, which depends on no machine. Processor time was measured on "
				   "two shared virtual cores that other programs used, too. It is good to a third.");
}

void addCosts(scenes::HtmlReport& page, const std::vector<MotionFindings>& all)
{
	page.heading("What each error costs");
	page.paragraph("The table has the slowest fixed step within the tolerance, with materials given, and its steps and queries for a "
				   "second of the scene. A dash says that no step of the sweep is, or that the reference cannot tell.");
	std::vector<std::string> head = {"scene"};
	for (const double tolerance : kTolerances) head.push_back("within " + formatNumber(tolerance));
	Table rows;
	for (const MotionFindings& f : all)
	{
		std::vector<std::string> row = {f.entry.name};
		for (const double tolerance : kTolerances)
		{
			const MotionRow* best = canTell(f, tolerance) ? f.cheapest(Contact::Given, tolerance) : nullptr;
			row.push_back(best
					? hertz(best->settings.rate) + (best->settings.forceError > 0 ? " at " + percent(best->settings.forceError) : "") +
						": " + formatNumber(best->cost.count(), 3)
					: "-");
		}
		rows.push_back(std::move(row));
	}
	page.table(head, rows);
	page.paragraph("The next table has the error at rates that games use, with materials given and with nothing set.");
	rows.clear();
	for (const MotionFindings& f : all)
	{
		std::vector<std::string> row = {f.entry.name};
		for (const Contact contact : {Contact::Given, Contact::Default})
			for (const int rate : {60, 120, 240, 480, 960}) row.push_back(errorAt(f, contact, rate));
		rows.push_back(std::move(row));
	}
	page.table(
		{"scene", "given: 60 Hz", "120 Hz", "240 Hz", "480 Hz", "960 Hz", "nothing set: 60 Hz", "120 Hz", "240 Hz", "480 Hz", "960 Hz"},
		rows);
}

void addSources(scenes::HtmlReport& page, const std::vector<MotionFindings>& all)
{
	page.heading("Where steps err, and where queries do");
	page.paragraph("Steps err by the first three columns, with the finest queries. Queries err by the others: the difference from the run "
				   "at 240 Hz with the finest queries. Coarse queries accept a force error of 5 % or 20 % (setForceError), or have trees "
				   "of fewer spheres than the scene's own 300 to 4,000. Only scenes in which trees meet are listed.");
	Table rows;
	const auto add = [](std::vector<std::string>& row, const MotionRow* r) { row.push_back(r ? shownError(r->queryError) : "-"); };
	for (const MotionFindings& f : all)
	{
		if (!f.entry.meetsTrees) continue;
		std::vector<std::string> row = {f.entry.name};
		for (const int rate : {60, 240, 960}) row.push_back(errorAt(f, Contact::Given, rate));
		for (const double error : kForceErrors) add(row, f.row(Contact::Given, kSphereRate, error));
		for (const int spheres : kFewSpheres) add(row, f.rowOfSpheres(spheres));
		const MotionRow *fine = f.row(Contact::Given, kSphereRate), *coarse = f.rowOfSpheres(kFewSpheres.front());
		row.push_back(fine && coarse && coarse->cost.pairs > 0 ? formatNumber(fine->cost.pairs / coarse->cost.pairs, 2) : "-");
		rows.push_back(std::move(row));
	}
	page.table({"scene", "steps: 60 Hz", "240 Hz", "960 Hz", "queries: within 5 %", "within 20 %", "100 spheres", "400 spheres",
				   "faces saved by 100 spheres, factor"},
		rows);
}

void addIntegrator(scenes::HtmlReport& page, const std::vector<MotionFindings>& all)
{
	const auto fall = std::find_if(
		all.begin(), all.end(), [](const MotionFindings& f) { return f.entry.name == std::string("free_fall"); });
	if (fall == all.end()) return;
	page.heading("What Bullet's own integrator errs");
	page.paragraph("Bullet adds gravity to the velocity and then moves the body by the new velocity. So a body that falls from rest is "
				   "ahead of g t^2 / 2, by g h t / 2 in steps of h. No contact is involved. The table has the lead after one second.");
	Table rows;
	for (const int rate : {30, 60, 120, 240, 480, 960, 1920, 9990})
	{
		const MotionRow *ours = fall->row(Contact::Given, rate), *stock = fall->row(Contact::Stock, rate);
		if (!ours) continue;
		rows.push_back({hertz(rate), formatNumber(1e3 * ours->closedError * fall->size, 3),
			stock ? formatNumber(1e3 * stock->closedError * fall->size, 3) : "-", formatNumber(1e3 * 0.5 * kGravity / rate, 3)});
	}
	page.table({"steps", "ours [mm]", "stock Bullet [mm]", "g h t / 2 [mm]"}, rows);
	page.paragraph("How much of the error of a scene is this lead? The next table has the error as it is, and with the lead taken away: "
				   "after each step a body that nothing touches is moved back by g h^2 / 2.");
	rows.clear();
	for (const MotionFindings& f : all)
	{
		if (!f.entry.fliesFreely) continue;
		std::vector<std::string> row = {f.entry.name};
		for (const int rate : {60, 240, 960})
			for (const bool isExact : {false, true})
			{
				const MotionRow* r = f.row(Contact::Given, rate, 0, isExact);
				row.push_back(r ? shownError(r->error) : "-");
			}
		rows.push_back(std::move(row));
	}
	page.table({"scene", "60 Hz", "moved back", "240 Hz", "moved back", "960 Hz", "moved back"}, rows);
}

void addStock(scenes::HtmlReport& page, const std::vector<MotionFindings>& all)
{
	page.heading("Stock Bullet beside");
	page.paragraph("Where a closed form is known, both are judged by it. It is that of rigid bodies. Our bodies sink in by their weight "
				   "over stiffness and area, which the closed forms of balls and blocks contain.");
	Table rows;
	for (const MotionFindings& f : all)
	{
		if (!f.entry.law) continue;
		std::vector<std::string> row = {f.entry.name, f.entry.law};
		for (const Contact contact : {Contact::Given, Contact::Default, Contact::Stock})
			for (const int rate : {60, 240, 960})
			{
				const MotionRow* r = f.row(contact, rate);
				row.push_back(r ? shownError(r->closedError) : "-");
			}
		row.push_back(shownError(f.truths[0].closedError));
		rows.push_back(std::move(row));
	}
	page.table({"scene", "closed form", "given: 60 Hz", "240 Hz", "960 Hz", "nothing set: 60 Hz", "240 Hz", "960 Hz", "stock: 60 Hz",
				   "240 Hz", "960 Hz", "the limit itself"},
		rows);
}

void addGains(scenes::HtmlReport& page, const std::vector<MotionFindings>& all)
{
	page.heading("What a step that adapts could save");
	page.paragraph(
		"For each tolerance the best fixed step is compared with the best step at each moment, chosen in hindsight: each interval between "
		"two checkpoints takes the run that costs least, so that the errors added in all intervals sum up to the tolerance. The error that "
		"a run adds in an interval is the change of its distance from the true motion, as a vector. For the fixed step it is summed alike. "
		"The tolerance is a share of the body for each second, times the growth of a perturbation. Tolerances that would allow more than a "
		"whole body are left out. The table has the ratio of the two costs, in steps and queries. It estimates the most that a control of "
		"the step could save, because no control knows the runs beforehand.");
	std::vector<std::string> head = {"scene", "events"};
	for (const double tolerance : kTolerances) head.push_back("within " + formatNumber(tolerance));
	Table rows;
	for (const MotionFindings& f : all)
	{
		std::vector<std::string> row = {f.entry.name, f.entry.hasEvents ? "yes" : "no"};
		for (const MotionGain& g : f.gains)
			row.push_back(g.byCount > 0 ? formatNumber(g.byCount, 3) + " (fixed: " + hertz(g.rate) + ")" : "-");
		rows.push_back(std::move(row));
	}
	const auto median = [&](const char* name, double MotionGain::*gain) {
		std::vector<std::string> row = {name, "yes"};
		for (size_t i = 0; i < kTolerances.size(); ++i)
		{
			const MedianGain m = medianGain(all, i, gain);
			row.push_back(m.scenes > 0 ? formatNumber(m.median, 3) + " (" + std::to_string(m.scenes) + " scenes)" : "-");
		}
		rows.push_back(std::move(row));
	};
	median("median of scenes with events", &MotionGain::byCount);
	median("the same by processor time", &MotionGain::bySeconds);
	median("the same, velocities charged", &MotionGain::byVelocity);
	median("a control of the step that knows no future", &MotionGain::byControl);
	median("the same, velocities charged", &MotionGain::byControlOfVelocity);
	std::vector<std::string> fixed = {"median of their best fixed steps", "yes"};
	for (size_t i = 0; i < kTolerances.size(); ++i)
	{
		std::vector<int> rates;
		for (const MotionFindings& f : all)
			if (f.entry.hasEvents && f.gains[i].byCount > 0) rates.push_back(f.gains[i].rate);
		std::sort(rates.begin(), rates.end());
		fixed.push_back(rates.empty() ? "-" : hertz(rates[rates.size() / 2]));
	}
	rows.push_back(std::move(fixed));
	page.table(head, rows);
	page.paragraph("An error of velocity that an impact makes shows in later poses. The row with velocities charged gives it to the "
				   "interval that makes it: with the change of velocity times the time that is left.");
	page.paragraph(
		"The control takes the coarsest step that should keep the errors so far within the share of the tolerance that the time so far "
		"allows. Where an interval errs by more, it is stepped again, finer, and both count. It learns the error of an interval once it "
		"has stepped through it, exactly and for nothing: half-steps that estimate it would cost half as much again or more. Scenes in "
		"which "
		"it misses the tolerance are left out.");
}

void addSingle(scenes::HtmlReport& page, const std::vector<MotionFindings>& all)
{
	page.heading("Single precision");
	page.paragraph("The same runs in Bullet's single precision, with materials given, against the true motion in double precision.");
	Table rows;
	for (const MotionFindings& f : all)
	{
		std::vector<std::string> row = {f.entry.name};
		for (const int rate : {60, 240, 960, 3840, 9990})
		{
			const MotionRow* r = f.row(Contact::Given, rate);
			row.push_back(r && r->singleError >= 0 ? shownError(r->singleError) + " / " + shownError(r->error) : "-");
		}
		rows.push_back(std::move(row));
	}
	page.table({"scene", "60 Hz, single / double", "240 Hz", "960 Hz", "3840 Hz", "9990 Hz"}, rows);
}

void addScenes(scenes::HtmlReport& page, const std::vector<MotionFindings>& all)
{
	page.heading("The scenes, and how well their true motion is known");
	Table rows;
	for (const MotionFindings& f : all)
	{
		std::vector<std::string> row = {
			f.entry.name, f.entry.about, std::to_string(f.bodies), formatNumber(f.entry.seconds, 2), hertz(f.referenceRate)};
		for (const MotionTruth& t : f.truths)
			for (const double value : {t.convergence, t.growth.factor, t.until}) row.push_back(formatNumber(value, 2));
		rows.push_back(std::move(row));
	}
	page.table({"scene", "what happens", "bodies", "duration [s]", "reference", "given: reference moves by", "growth of a millionth",
				   "judged until [s]", "nothing set: reference moves by", "growth", "judged until [s]"},
		rows);
}

/// Error over time of processor, with the front of the best choices.
scenes::Chart chartOf(const MotionFindings& f)
{
	scenes::Chart chart{
		f.entry.name, "processor time for a second of the scene [ms]", "largest error of a pose, share of the body", {}, true};
	std::vector<std::pair<double, double>> ours;
	const auto series = [&](const char* name, Contact contact, double forceError) {
		scenes::ChartSeries points{name, {}, {}, {}, true};
		for (const MotionRow& r : f.rows)
			if (r.settings.contact == contact && r.settings.forceError == forceError && !r.settings.isFlightExact &&
				r.settings.spheres == 0 && std::isfinite(r.error))
			{
				points.x.push_back(1e3 * r.cost.seconds), points.y.push_back(r.error);
				if (contact == Contact::Given) ours.push_back({1e3 * r.cost.seconds, r.error});
			}
		if (!points.x.empty()) chart.series.push_back(std::move(points));
	};
	series("materials given", Contact::Given, 0);
	series("nothing set", Contact::Default, 0);
	series("stock Bullet", Contact::Stock, 0);
	series("queries within 5 %", Contact::Given, kForceErrors[0]);
	series("queries within 20 %", Contact::Given, kForceErrors[1]);
	scenes::ChartSeries front{"best of ours, materials given", {}, {}, {}, false};
	std::sort(ours.begin(), ours.end());
	for (const auto& [cost, error] : ours)
		if (front.y.empty() || error < front.y.back()) front.x.push_back(cost), front.y.push_back(error);
	chart.series.push_back(std::move(front));
	return chart;
}
}  // namespace

scenes::HtmlReport makePage(const std::vector<MotionFindings>& all)
{
	scenes::HtmlReport page("Accuracy of the motion");
	addSummary(page, all);
	addMethod(page, all.size());
	addCosts(page, all);
	addSources(page, all);
	addIntegrator(page, all);
	addStock(page, all);
	addGains(page, all);
	addSingle(page, all);
	addScenes(page, all);
	page.heading("Error over cost, scene by scene");
	page.paragraph("Each point is a run in fixed steps, and the line joins the best ones. Stock Bullet is judged by the motion of our "
				   "bodies with materials given, which are not as hard as its own.");
	for (const MotionFindings& f : all) page.chart(chartOf(f));
	return page;
}
}  // namespace bench
