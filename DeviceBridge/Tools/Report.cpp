// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Tools/Commands.h"

#include <cstdio>

namespace devicebridge::tools
{
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
	for (const auto& [name, value] : report.fields())
	{
		if (name == "schema") continue;
		const bool rows = value[0].isObject();
		if (!rows) std::printf("%s: %s\n", name.c_str(), (value.isText() ? value.text() : value.dump()).c_str());
		for (std::size_t i = 0; rows && i < value.size(); ++i)
			std::printf("%s %s\n", i ? " " : (name + ":\n ").c_str(), value[i].dump().c_str());
	}
}

int fail(const std::string& message, int code)
{
	std::fprintf(stderr, "devicebridge: %s\n", message.c_str());
	return code;
}
}  // namespace devicebridge::tools
