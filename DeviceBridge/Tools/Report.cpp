// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Tools/Commands.h"

#include <cstdio>
#include <string_view>

#include "BulletISTCollision/Json/ReadableText.h"

namespace devicebridge::tools
{
namespace
{
struct FieldUnit
{
	std::string_view field, unit;
};
// Fields of all commands; a name has the same unit in each.
constexpr FieldUnit kUnits[] = {{"peak_force", "N"}, {"continuous_force", "N"}, {"peak_torque", "N m"}, {"continuous_torque", "N m"},
	{"max_stiffness", "N/m"}, {"max_angular_stiffness", "N m/rad"}, {"max_damping", "N s/m"}, {"max_angular_damping", "N m s/rad"},
	{"damping", "N s/m"}, {"angular_damping", "N m s/rad"}, {"device_damping", "N s/m"}, {"resolution", "m"}, {"angular_resolution", "rad"},
	{"workspace_radius", "m"}, {"nominal_rate", "Hz"}, {"mass", "kg"}, {"delay", "s"}, {"stable", "N/m"}, {"predicted", "N/m"},
	{"passive", "N/m"}, {"passive_measured", "N/m"}, {"energy", "J"}, {"x", "m"}, {"y", "m"}, {"z", "m"}, {"bytes", "B"}};

std::string unitOf(std::string_view field)
{
	for (const FieldUnit& known : kUnits)
		if (known.field == field) return std::string(known.unit);
	return ist::unitAtEnd(field);
}
}  // namespace

Report newReport()
{
	Report report;
	report["schema"] = 1;
	return report;
}

void print(const Report& report, bool json)
{
	if (json)
	{
		std::printf("%s\n", report.dump().c_str());
		return;
	}
	std::fputs(ist::readableText(report, unitOf).c_str(), stdout);
}

int fail(const std::string& message, int code)
{
	std::fprintf(stderr, "devicebridge: %s\n", message.c_str());
	return code;
}
}  // namespace devicebridge::tools
