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

bool isGood(const GraspReportOutcome::Row& row, double strongest)
{
	for (const GraspOutcome* o : {&row.rough, &row.smooth})
		if (o->peakForce > kForceSlack * strongest) return false;
	if (std::fabs(row.mapForce - 1) > kMapSlack || !row.rough.held) return false;
	// A user's own body may be unable to stand, or the hand may hook it, so only the holding is judged.
	return row.own || (row.rough.putDown && row.rough.quality.forceClosure && !row.smooth.held);
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
	if (auto error = devicebridge::saveHeatMap(map, path + ".ply")) return *error;
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

bool GraspReportOutcome::ok() const
{
	for (const Row& row : rows)
		if (!isGood(row, strongestAllowed)) return false;
	return !rows.empty();
}

Result<GraspReportOutcome> runGraspReport(const GraspReportOptions& options)
{
	GraspReportOutcome outcome;
	outcome.strongestAllowed = devicebridge::BulletHandSettings().maxForce;
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
	for (const GraspReportOutcome::Row& row : o.rows)
	{
		const std::string name = row.rough.object + ", friction " + formatNumber(row.rough.friction, 2) + ": ";
		rows.push_back({name + (row.rough.held ? "held, slip" : "LOST, slip"), formatNumber(1e3 * row.rough.slip, 2), "mm"});
		rows.push_back({name + "strongest part", formatNumber(row.rough.peakForce, 3), "N"});
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
	Json json = {{"schema", 1}, {"demo", "grasps"}, {"ok", o.ok()}, {"grasps", Json::list()}};
	for (const GraspReportOutcome::Row& row : o.rows)
		for (const GraspOutcome* g : {&row.rough, &row.smooth})
			json["grasps"].append({{"object", g->object}, {"mass", row.mass}, {"friction", g->friction}, {"held", g->held},
				{"put_down", g->putDown}, {"slip", g->slip}, {"slip_angle", g->slipAngle}, {"peak_force", g->peakForce},
				{"coupling_force", g->couplingForce}, {"holding_force", g->holdingForce}, {"parts", g->parts},
				{"force_closure", g->quality.forceClosure}, {"epsilon", g->quality.epsilon}, {"energy_residual", g->energy.residual},
				{"white_impulse", row.scales.impulse}, {"white_pressure", row.scales.pressure}, {"complaints", g->complaints}});
	return json.dump();
}
}  // namespace scenes
