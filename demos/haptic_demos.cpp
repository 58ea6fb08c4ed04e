// SPDX-License-Identifier: Zlib
#include "demos/scenes/MeshToQuery.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

namespace
{
#ifdef IST_VERSION
constexpr const char* kVersion = IST_VERSION;
#else
constexpr const char* kVersion = "0.1.0";
#endif

constexpr const char* kUsage =
	"usage: haptic_demos --list | --version | --demo NAME [options]\n"
	"  --mesh FILE     mesh to use (default: the bunny of glmark2-data)\n"
	"  --unit METRES   metres per unit of the file (default: the longest side becomes 0.2 m)\n"
	"  --spheres N     spheres to pack (default 10000)\n"
	"  --report FILE   write a report as one HTML file\n"
	"  --json          print the result as JSON instead of a table\n"
	"  --headless      no window (this demo never opens one)\n";

struct Arguments
{
	bool list = false, version = false, help = false, json = false;
	std::string demo, mesh = "/usr/share/glmark2/models/bunny.obj", report;
	double unit = 0;
	long long spheres = 10000;
	std::string error;
};

/// The whole of `text` as a positive finite number, else 0.
double positiveNumber(const std::string& text)
{
	char* end = nullptr;
	const double value = std::strtod(text.c_str(), &end);
	return end != text.c_str() && *end == 0 && std::isfinite(value) && value > 0 ? value : 0;
}

Arguments parse(int argc, char** argv)
{
	Arguments a;
	for (int i = 1; i < argc && a.error.empty(); ++i)
	{
		const std::string name = argv[i];
		if (name == "--list") a.list = true;
		else if (name == "--version") a.version = true;
		else if (name == "--help" || name == "-h") a.help = true;
		else if (name == "--json") a.json = true;
		else if (name == "--headless") continue;
		else if (name != "--demo" && name != "--mesh" && name != "--report" && name != "--unit" && name != "--spheres")
			a.error = "unknown option " + name;
		else if (i + 1 == argc)
			a.error = name + " needs a value";
		else
		{
			const std::string value = argv[++i];
			if (name == "--demo") a.demo = value;
			if (name == "--mesh") a.mesh = value;
			if (name == "--report") a.report = value;
			if (name == "--unit") a.unit = positiveNumber(value);
			if (name == "--spheres") a.spheres = static_cast<long long>(std::fmin(positiveNumber(value), 1e9));
			if (name == "--unit" && !(a.unit > 0)) a.error = "--unit must be a positive number of metres, not " + value;
			if (name == "--spheres" && a.spheres < 1) a.error = "--spheres must be a positive number, not " + value;
		}
	}
	return a;
}

bool showProgress(const char* stage, double fraction)
{
	static std::string last;
	char line[64];
	std::snprintf(line, sizeof line, "%-12s %3.0f %%", stage, 100 * fraction);
	if (line != last) std::fprintf(stderr, "\r%s", line);
	last = line;
	return true;
}

int runBunnyQuery(const Arguments& a)
{
	scenes::MeshToQueryOptions options;
	options.mesh = a.mesh;
	options.unit = a.unit;
	options.spheres = a.spheres;
	options.progress = showProgress;
	const ist::Result<scenes::MeshToQueryOutcome> outcome = scenes::runMeshToQuery(options);
	std::fprintf(stderr, "\r%-20s\r", "");
	if (!outcome)
	{
		std::fprintf(stderr, "haptic_demos: %s\n", outcome.error().message.c_str());
		if (a.mesh == Arguments().mesh) std::fprintf(stderr, "The default mesh comes with: apt-get install glmark2-data\n");
		return 1;
	}
	if (a.json)
		std::printf("%s\n", scenes::makeJson(outcome.value()).c_str());
	else
		for (const auto& row : scenes::summaryRows(outcome.value()))
			std::printf("%-36s %12s %s\n", row[0].c_str(), row[1].c_str(), row[2].c_str());
	if (a.report.empty()) return 0;
	if (!scenes::makeReport(outcome.value()).write(a.report))
	{
		std::fprintf(stderr, "haptic_demos: cannot write the report to %s\n", a.report.c_str());
		return 1;
	}
	std::fprintf(stderr, "report: %s\n", a.report.c_str());
	return 0;
}

int run(int argc, char** argv)
{
	const Arguments a = parse(argc, argv);
	if (!a.error.empty())
	{
		std::fprintf(stderr, "haptic_demos: %s\n%s", a.error.c_str(), kUsage);
		return 2;
	}
	if (a.version) return std::printf("haptic_demos %s\n", kVersion), 0;
	if (a.list) return std::printf("bunny-query  mesh to tree to force: a probe pressed on the bunny and slid over its back\n"), 0;
	if (a.help) return std::printf("%s", kUsage), 0;
	if (a.demo == "bunny-query") return runBunnyQuery(a);
	if (a.demo.empty())
		std::fprintf(stderr, "haptic_demos: nothing to do\n%s", kUsage);
	else
		std::fprintf(stderr, "haptic_demos: no demo is called %s; --list names them\n", a.demo.c_str());
	return 2;
}
}  // namespace

int main(int argc, char** argv)
{
	try
	{
		return run(argc, argv);
	}
	catch (const std::exception& e)
	{
		std::fprintf(stderr, "haptic_demos: %s\n", e.what());
		return 1;
	}
}
