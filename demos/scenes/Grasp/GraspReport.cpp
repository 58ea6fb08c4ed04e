// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/GraspReport.h"

#include "BulletISTCollision/Json/JsonValue.h"
#include "DeviceBridge/Hand/Grasp/HeatMapFile.h"

#include <cmath>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kForceSlack = 1.02, kMapSlack = 0.02;

std::string of(const GraspOutcome& o) { return o.object + ", friction " + formatNumber(o.friction, 2) + ": "; }

/// Why an object was not held.
std::string whyLost(const GraspOutcome& o, double mass)
{
	if (!o.touched)
		return of(o) + "the hand closed and touched nothing, as where an object is lower than it: turn it (--up), or give another --unit.";
	const bool lifted = o.lostAt > GraspMotion::kLifted + 0.01;
	return of(o) + (lifted ? "lost at " + formatNumber(o.lostAt, 2) + " s" : "not lifted") + ", " +
		formatNumber(1e3 * std::fabs(o.lostHeight), 2) + (o.lostHeight < 0 ? " mm below" : " mm above") + " its start, where more than " +
		formatNumber(1e3 * GraspOutcome::kOffTable, 2) + " mm are asked: the parts pressed with " + formatNumber(o.gripForce, 2) +
		" N in all, of which friction bears " + formatNumber(o.friction * o.gripForce, 2) + " N, and it weighs " +
		formatNumber(9.81 * mass, 2) + " N.";
}

void judgeForce(std::vector<std::string>& failures, const GraspOutcome& o, const char* part, double force, double limit)
{
	if (force > kForceSlack * limit)
		failures.push_back(of(o) + part + " was pressed with " + formatNumber(force, 3) + " N, " +
			formatNumber(100 * (force / limit - 1), 2) + " % more than the " + formatNumber(limit, 3) + " N of its coupling; " +
			formatNumber(100 * (kForceSlack - 1), 2) + " % are allowed.");
}

void judge(std::vector<std::string>& failures, const GraspReportOutcome& all, const GraspReportOutcome::Row& row)
{
	if (!row.rough.held) failures.push_back(whyLost(row.rough, row.mass));
	for (const GraspOutcome* o : {&row.rough, &row.smooth})
	{
		judgeForce(failures, *o, "a bone", o->peakForce, all.strongestAllowed);
		judgeForce(failures, *o, "the palm", o->palmForce, all.palmAllowed);
	}
	if (row.rough.touched && !(std::fabs(row.mapForce - 1) <= kMapSlack))
		failures.push_back(of(row.rough) + "the map has " + formatNumber(100 * row.mapForce, 4) + " % of the contacts' impulse, and " +
			formatNumber(100 * kMapSlack, 2) + " % off are allowed.");
	// A user's own body may be unable to stand, or the hand may hook it, so only the holding is judged.
	if (row.own) return;
	if (!row.rough.putDown) failures.push_back(of(row.rough) + "it did not come to rest on the table at the end.");
	if (!row.rough.quality.forceClosure) failures.push_back(of(row.rough) + "the grasp has no force closure.");
	if (row.smooth.held) failures.push_back(of(row.smooth) + "held, though friction should not bear its weight.");
}

Chart chartOf(const GraspOutcome& o, const std::string& title, const std::string& label, double GraspSample::*value, double scale)
{
	Chart chart{title, "time [s]", label, {}};
	chart.series.push_back({o.object, {}, {}, {}, false});
	for (const GraspSample& sample : o.samples)
	{
		chart.series[0].x.push_back(sample.time);
		chart.series[0].y.push_back(scale * sample.*value);
	}
	return chart;
}

Result<TextureScales> saveMaps(const devicebridge::HeatMap& map, const GraspObject& object, const std::string& path)
{
	if (auto error = object.fileVertices.empty() ? devicebridge::saveHeatMap(map, path + ".ply")
												 : devicebridge::saveHeatMapOfFile(map, object.fileVertices, path + ".ply"))
		return *error;
	if (auto error = devicebridge::saveHeatMapTable(map, path + ".csv")) return *error;
	if (object.texture.places.empty()) return TextureScales();
	return saveTextures(map, object.texture, path);
}

Result<GraspReportOutcome::Row> runRow(const std::string& object, const GraspReportOptions& options)
{
	GraspOptions grasp = options.grasp;
	grasp.object = object;
	const auto scene = GraspScene::make(grasp);
	if (!scene) return scene.error();
	GraspScene& s = *scene.value();
	GraspReportOutcome::Row row;
	row.mass = s.object().mass;
	row.own = !grasp.mesh.empty();
	const auto map = s.makeHeatMap();
	double impulse = 0, onMap = 0;
	Result<GraspOutcome> rough = runGrasp(s, options.enough, [&] { impulse += s.addTouches(*map) * s.stepSize(); });
	if (!rough) return rough.error();
	row.rough = std::move(rough).value();
	for (const devicebridge::HeatMap::Vertex& v : map->vertices()) onMap += v.impulse;
	row.mapForce = impulse > 0 ? onMap / impulse : 0;
	row.map = map->summary();
	Result<GraspOutcome> smooth = runGrasp(s, options.tooLittle);
	if (!smooth) return smooth.error();
	row.smooth = std::move(smooth).value();
	if (options.maps.empty()) return row;
	const auto scales = saveMaps(*map, s.object(), options.maps + "-" + s.object().name);
	if (!scales) return scales.error();
	row.scales = scales.value();
	return row;
}
}  // namespace

std::vector<std::string> GraspReportOutcome::failures() const
{
	std::vector<std::string> all;
	for (const Row& row : rows) judge(all, *this, row);
	return all;
}

Result<GraspReportOutcome> runGraspReport(const GraspReportOptions& options)
{
	GraspReportOutcome outcome;
	outcome.strongestAllowed = options.grasp.hand.maxForce;
	outcome.palmAllowed = options.grasp.hand.palmForce;
	const bool own = !options.grasp.mesh.empty();
	for (const std::string& object : own ? std::vector<std::string>{std::string()} : graspObjectNames())
	{
		Result<GraspReportOutcome::Row> row = runRow(object, options);
		if (!row) return row.error();
		outcome.rows.push_back(std::move(row).value());
	}
	return outcome;
}

std::vector<std::vector<std::string>> summaryRows(const GraspReportOutcome& o)
{
	std::vector<std::vector<std::string>> rows = {{"Result", o.ok() ? "ok" : "FAILED", ""}};
	for (const std::string& failure : o.failures()) rows.push_back({"  " + failure, "", ""});
	for (const GraspReportOutcome::Row& row : o.rows)
	{
		const std::string name = row.rough.object + ", friction " + formatNumber(row.rough.friction, 2) + ": ";
		rows.push_back({name + (row.rough.held ? "held, slip" : "LOST, slip"), formatNumber(1e3 * row.rough.slip, 2), "mm"});
		rows.push_back({name + "strongest bone, of " + formatNumber(o.strongestAllowed, 3), formatNumber(row.rough.peakForce, 3), "N"});
		rows.push_back({name + "palm, of " + formatNumber(o.palmAllowed, 3), formatNumber(row.rough.palmForce, 3), "N"});
		rows.push_back({name + "all parts, at rest in the air", formatNumber(row.rough.holdingForce, 3), "N"});
		rows.push_back(
			{name + "epsilon", formatNumber(row.rough.quality.epsilon, 3), row.rough.quality.forceClosure ? "N, closed" : "N, NOT closed"});
		rows.push_back({name + "force on the map, of the contacts'", formatNumber(100 * row.mapForce, 4), "%"});
		rows.push_back({name + "energy without a name", formatNumber(1e3 * row.rough.energy.residual, 2), "mJ"});
		rows.push_back({row.rough.object + ", friction " + formatNumber(row.smooth.friction, 2), row.smooth.held ? "HELD" : "slips", ""});
	}
	return rows;
}

HtmlReport makeReport(const GraspReportOutcome& o)
{
	HtmlReport report(o.rows.size() == 1 ? "A grasp of " + o.rows[0].rough.object : std::string("Grasps of six objects"));
	report.paragraph("A hand of sixteen parts, each pulled to its place by a saturating coupling, approaches, closes, lifts, turns, rests, "
					 "shakes at 2 Hz, puts "
					 "down and lets go. Slip: largest way of the centre of mass in the palm between lifting and the end of shaking. "
					 "Epsilon: Ferrari and Canny, "
					 "torques over half the object's longest side.");
	report.table({"Quantity", "Value", "Unit"}, summaryRows(o));
	for (const GraspReportOutcome::Row& row : o.rows)
	{
		report.heading(row.rough.object);
		std::vector<std::vector<std::string>> table;
		for (const auto& part : row.map)
			if (part.dwell > 0)
				table.push_back({part.name, std::to_string(part.id), formatNumber(1e6 * part.area, 3), formatNumber(part.dwell, 3),
					formatNumber(part.meanForce, 3), formatNumber(part.peakForce, 3), formatNumber(1e3 * part.depth, 3)});
		report.table({"Part", "GRAB's label", "area [mm^2]", "dwell [s]", "mean force [N]", "peak force [N]", "largest depth [mm]"}, table);
		if (row.scales.pressure > 0)
			report.paragraph("Painted into its texture: beside this page lie " + row.rough.object +
				"'s picture in the fingers' colours, which the .obj shows on the mesh, and pictures of impulse (white: " +
				formatNumber(row.scales.impulse, 3) + " N s/m^2) and mean pressure (white: " + formatNumber(1e-3 * row.scales.pressure, 3) +
				" kPa).");
		report.chart(chartOf(row.rough, "Sum of the forces on the parts", "force [N]", &GraspSample::force, 1));
		report.chart(chartOf(row.rough, "Height over the place where it stood", "height [mm]", &GraspSample::height, 1e3));
		report.chart(chartOf(row.rough, "Slip in the palm", "slip [mm]", &GraspSample::slip, 1e3));
	}
	return report;
}

std::string makeJson(const GraspReportOutcome& o)
{
	using Json = JsonValue;
	Json json = {{"schema", 1}, {"demo", "grasps"}, {"ok", o.ok()}, {"failures", Json::list()}, {"grasps", Json::list()}};
	for (const std::string& failure : o.failures()) json["failures"].append(failure);
	for (const GraspReportOutcome::Row& row : o.rows)
		for (const GraspOutcome* g : {&row.rough, &row.smooth})
			json["grasps"].append({{"object", g->object}, {"mass", row.mass}, {"friction", g->friction}, {"held", g->held},
				{"put_down", g->putDown}, {"slip", g->slip}, {"slip_angle", g->slipAngle}, {"peak_force", g->peakForce},
				{"palm_force", g->palmForce}, {"coupling_force", g->couplingForce}, {"holding_force", g->holdingForce}, {"parts", g->parts},
				{"force_closure", g->quality.forceClosure}, {"epsilon", g->quality.epsilon}, {"energy_residual", g->energy.residual},
				{"white_impulse", row.scales.impulse}, {"white_pressure", row.scales.pressure}, {"complaints", g->complaints}});
	return json.dump();
}
}  // namespace scenes
