// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/ZWidthPage.h"

#include "BulletISTCollision/Json/JsonValue.h"

#include <algorithm>
#include <cmath>

using devicebridge::ZWidthPoint;

namespace scenes
{
namespace
{
constexpr int kDampings = 9;
constexpr double kTick = 1e-3;        // [s]
constexpr double kSmallShare = 0.02;  // limit of (b + B)(T/2 + t_d)/m, below which the closed form holds within 5 %

std::string nameOf(const ZWidthCurve& c) { return c.delayTicks == 0 ? "no delay" : std::to_string(c.delayTicks) + " ms delay"; }

ChartSeries series(const std::string& name, const ZWidthCurve& curve, double ZWidthPoint::*value, bool markers = false)
{
	ChartSeries out{name, {}, {}, {}, markers};
	for (const ZWidthPoint& p : curve.points)
	{
		out.x.push_back(p.damping);
		out.y.push_back(1e-3 * p.*value);
	}
	return out;
}

void judge(const ZWidthDevice& device, const ZWidthCurve& curve, ZWidthOutcome& out)
{
	if (curve.quantised) return;
	for (const ZWidthPoint& p : curve.points)
	{
		const double share = (device.damping + p.damping) * (0.5 + curve.delayTicks) * kTick / device.mass;
		if (share <= kSmallShare)
		{
			out.stableError = std::max(out.stableError, std::fabs(p.stable / p.predicted - 1));
			++out.stablePoints;
		}
		if (curve.delayTicks > 0) continue;
		if (p.passive > 0) out.passiveOverBound = std::max(out.passiveOverBound, p.passiveMeasured / p.passive);
		out.passiveOverStable = std::max(out.passiveOverStable, p.passiveMeasured / p.stable);
	}
}

void addDevice(HtmlReport& report, const ZWidthDevice& d)
{
	report.heading(d.model);
	report.paragraph("Handle and hand " + formatNumber(d.mass) + " kg, mechanism " + formatNumber(d.damping) + " N s/m, sensor " +
		formatNumber(1e6 * d.resolution) + " \xC2\xB5m.");
	Chart stable{"Stable region, its upper end", "damping B of the wall [N s/m]", "stiffness K [kN/m]", {}};
	Chart passive{"Passive region, its upper end", "damping B of the wall [N s/m]", "stiffness K [kN/m]", {}};
	Chart steps{"With the steps of the sensor: upper ends of the stable region, and of the passive one without delay",
		"damping B of the wall [N s/m]", "stiffness K [kN/m]", {}};
	for (const ZWidthCurve& c : d.curves)
	{
		if (!c.quantised) stable.series.push_back(series(nameOf(c), c, &ZWidthPoint::stable));
		if (!c.quantised) passive.series.push_back(series(nameOf(c), c, &ZWidthPoint::passiveMeasured));
		if (c.quantised) steps.series.push_back(series(nameOf(c), c, &ZWidthPoint::stable));
	}
	for (const ZWidthCurve& c : d.curves)
		if (c.quantised && c.delayTicks == 0) steps.series.push_back(series("passive, no delay", c, &ZWidthPoint::passiveMeasured));
	ChartSeries predicted{"(b + B)/(T/2 + t)", {}, {}, {}, true};
	for (const ZWidthCurve& c : d.curves)
	{
		const ChartSeries of = series("", c, &ZWidthPoint::predicted, true);
		if (c.quantised) continue;
		predicted.x.insert(predicted.x.end(), of.x.begin(), of.x.end());
		predicted.y.insert(predicted.y.end(), of.y.begin(), of.y.end());
	}
	stable.series.push_back(predicted);
	for (const ZWidthCurve& c : d.curves)
		if (!c.quantised && c.delayTicks == 0) passive.series.push_back(series("2 (b - B)/T", c, &ZWidthPoint::passive, true));
	report.chart(stable);
	report.chart(passive);
	report.chart(steps);
}
}  // namespace

ist::Result<ZWidthOutcome> runZWidth(const std::vector<std::string>& profiles, const std::vector<int>& delays)
{
	ZWidthOutcome out;
	for (const std::string& name : profiles)
	{
		const auto profile = devicebridge::simulatedProfile(name);
		if (!profile) return profile.error();
		ZWidthDevice& d = out.devices.emplace_back();
		d.profile = name, d.model = profile.value().info.model;
		d.mass = profile.value().mass, d.damping = profile.value().damping, d.resolution = profile.value().info.resolution;
		std::vector<double> dampings;
		for (int i = 0; i < kDampings; ++i) dampings.push_back(2 * d.damping * i / (kDampings - 1));
		for (const bool quantised : {false, true})
			for (const int delay : delays)
			{
				d.curves.push_back({delay, quantised, devicebridge::measureZWidth(profile.value(), delay, dampings, quantised)});
				judge(d, d.curves.back(), out);
			}
	}
	return out;
}

std::vector<std::vector<std::string>> summaryRows(const ZWidthOutcome& o)
{
	std::vector<std::vector<std::string>> rows = {{"Result", o.ok() ? "ok" : "FAILED", ""},
		{"Stable region, largest error of (b + B)/(T/2 + t)", formatNumber(100 * o.stableError, 3), "%"},
		{"at so many points, where that form holds", std::to_string(o.stablePoints), ""},
		{"Passive region, most, over 2 (b - B)/T", formatNumber(o.passiveOverBound, 6), ""},
		{"Passive region, most, over the stable one", formatNumber(o.passiveOverStable, 3), ""}};
	for (const ZWidthDevice& d : o.devices)
		for (const ZWidthCurve& c : d.curves)
			if (!c.quantised)
				rows.push_back(
					{d.model + ", " + nameOf(c) + ", stable K without damping", formatNumber(c.points.front().stable, 4), "N/m"});
	return rows;
}

HtmlReport makeReport(const ZWidthOutcome& o)
{
	HtmlReport report("Which walls a device bears");
	report.paragraph(
		"A wall F = -K x - B v, held over each tick of a millisecond, on simulated devices without a hand. Stable: the free handle, let go "
		"in "
		"the wall, swings less and less. Passive: nothing that a hand can do takes energy out of wall and mechanism; tried are triangles "
		"and "
		"sines of 2 to 458 ticks. Points are the closed forms: (b + B)/(T/2 + t), with t the delay, for the stable region where "
		"(b + B)(T/2 + t) is small beside the mass (Gil and Hulin), and 2 (b - B)/T for the passive one without delay (Colgate and "
		"Schenkel).");
	report.table({"Quantity", "Value", "Unit"}, summaryRows(o));
	for (const ZWidthDevice& d : o.devices) addDevice(report, d);
	return report;
}

std::string makeJson(const ZWidthOutcome& o)
{
	using Json = ist::JsonValue;
	Json json = {{"schema", 1}, {"demo", "z-width"}, {"ok", o.ok()}, {"stable_error", o.stableError}, {"stable_points", o.stablePoints},
		{"passive_over_bound", o.passiveOverBound}, {"passive_over_stable", o.passiveOverStable}, {"curves", Json::list()}};
	for (const ZWidthDevice& d : o.devices)
		for (const ZWidthCurve& c : d.curves)
		{
			Json curve = {{"profile", d.profile}, {"delay_s", kTick * c.delayTicks}, {"quantised", c.quantised}, {"points", Json::list()}};
			for (const ZWidthPoint& p : c.points)
				curve["points"].append({{"damping", p.damping}, {"stable", p.stable}, {"predicted", p.predicted}, {"passive", p.passive},
					{"passive_measured", p.passiveMeasured}});
			json["curves"].append(std::move(curve));
		}
	return json.dump();
}
}  // namespace scenes
