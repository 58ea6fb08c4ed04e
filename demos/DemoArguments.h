// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace scenes
{
struct DemoArguments
{
	static constexpr const char* kDefaultMesh = "/usr/share/glmark2/models/bunny.obj";

	bool list = false, version = false, help = false, json = false, virtualTime = false, decoupled = false;
	std::string demo, scene, paperFigures, mesh = kDefaultMesh, report, cache = ".", scenes = "data/scenes";
	double unit = 0;
	double worldRate = 60;
	long long spheres = 10000;
	std::string error;  ///< what is wrong; empty: nothing
};

extern const char* const kDemoUsage;

DemoArguments parseDemoArguments(int argc, char** argv);
}  // namespace scenes
