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
	// Names that a device reports need not be UTF-8.
	const auto dump = [](const Report& value) { return value.dump(-1, ' ', false, Report::error_handler_t::replace); };
	if (json)
	{
		std::printf("%s\n", dump(report).c_str());
		return;
	}
	for (const auto& [name, value] : report.items())
	{
		if (name == "schema") continue;
		const bool rows = value.is_array() && !value.empty() && value.front().is_object();
		if (!rows) std::printf("%s: %s\n", name.c_str(), value.is_string() ? value.get<std::string>().c_str() : dump(value).c_str());
		for (std::size_t i = 0; rows && i < value.size(); ++i)
			std::printf("%s %s\n", i ? " " : (name + ":\n ").c_str(), dump(value[i]).c_str());
	}
}

int fail(const std::string& message, int code)
{
	std::fprintf(stderr, "devicebridge: %s\n", message.c_str());
	return code;
}
}  // namespace devicebridge::tools
