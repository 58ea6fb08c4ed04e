// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/MeshAxes.h"

#include <optional>
#include <string>
#include <vector>

namespace scenes
{
struct DemoArguments
{
	static constexpr const char* kDefaultMesh = "/usr/share/glmark2/models/bunny.obj";

	bool list = false, version = false, help = false, json = false, virtualTime = false, decoupled = false;
	std::string demo, scene, study, results = ".", paperFigures, mesh = kDefaultMesh, report, cache = ".", scenes = "data/scenes";
	double unit = 0;  ///< [m]; 0: not given
	std::optional<ist::UpAxes> up;
	double mass = 0, friction = 0;  ///< of the mesh of a grasp; 0: not given
	std::vector<std::string> set;   ///< of a scene file: FIELD=VALUE
	double worldRate = 60;
	long long spheres = 10000;
	int participant = 0;  ///< of a study, from 1
	bool meshGiven = false, spheresGiven = false;
	// Of the browser's demos.
	bool headless = false, sizeGiven = false, besideStock = false, forces = false;
	std::string screenshot, record, gallery, windowScreenshot, device, show, saveScene;
	long long frames = -1;
	double dt = 0;  ///< [s]; 0: the demo's own
	bool contactCache = true;
	double maxError = 0.05;  ///< that the contact cache may add to forces
	double forceError = 0;   ///< that coarser levels may add to them
	int width = 960, height = 540;
	/// Something is asked for that a window does not give.
	bool withoutWindow() const
	{
		return headless || json || !screenshot.empty() || !record.empty() || !report.empty() || !saveScene.empty();
	}

	std::string error;  ///< what is wrong; empty: nothing
};

extern const char* const kDemoUsage;

DemoArguments parseDemoArguments(int argc, char** argv);
}  // namespace scenes
