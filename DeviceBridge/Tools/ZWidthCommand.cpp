// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/ZWidth.h"
#include "DeviceBridge/Tools/Commands.h"

namespace devicebridge::tools
{
int runZWidth(const ZWidthArguments& arguments)
{
	const std::string scheme = "sim:";
	if (arguments.uri.compare(0, scheme.size(), scheme) != 0)
		return fail("the Z-width is measured on simulated devices only (sim:NAME), not on " + arguments.uri);
	const auto profile = simulatedProfile(arguments.uri.substr(scheme.size()));
	if (!profile) return fail(profile.error().message);
	const double b = profile.value().damping, most = arguments.most < 0 ? 2 * b : arguments.most;
	std::vector<double> dampings;
	for (int i = 0; i < arguments.steps; ++i) dampings.push_back(arguments.steps > 1 ? most * i / (arguments.steps - 1) : 0);
	Report report = newReport();
	report["uri"] = arguments.uri;
	report["mass"] = profile.value().mass;
	report["device_damping"] = b;
	report["delay"] = 1e-3 * arguments.delayTicks;
	report["resolution"] = arguments.quantised ? profile.value().info.resolution : 0;
	Report& rows = report["points"] = Report::list();
	for (const ZWidthPoint& p : measureZWidth(profile.value(), arguments.delayTicks, dampings, arguments.quantised))
		rows.append({{"damping", p.damping}, {"stable", p.stable}, {"predicted", p.predicted}, {"passive", p.passive},
			{"passive_measured", p.passiveMeasured}});
	print(report, arguments.json);
	return kGood;
}
}  // namespace devicebridge::tools
