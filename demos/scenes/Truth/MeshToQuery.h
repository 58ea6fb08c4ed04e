// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"
#include "demos/scenes/Pages/HtmlReport.h"

#include <optional>
#include <string>
#include <vector>

namespace scenes
{
/// A mesh becomes a tree. A round probe is pressed on it from above, slides along x over its back, and is lifted off.
struct MeshToQueryOptions
{
	std::string mesh;
	std::optional<ist::UpAxes> up;  ///< turn of that mesh
	double unit = 0;                ///< unit of the file [m]; 0: the longest side becomes 0.2 m
	int64_t spheres = 10000;
	int steps = 400;
	int comparisons = 20;                      ///< number of steps that are compared with quadrature
	double probeRadius = 0.02, depth = 0.004;  ///< [m]
	double stiffness = 1e7;                    ///< [Pa/m]
	ist::Progress progress;
};

/// One step of the probe's path. Forces act on the mesh.
struct PathStep
{
	ist::Vec3 probe;               ///< centre of the probe [m]
	double volume = 0, force = 0;  ///< [m^3], [N]
	ist::OverlapError sigma;
	int64_t pairs = 0;
	double seconds = 0;  ///< time of the query
};

struct Comparison
{
	int step = 0;
	double volumeTruth = 0, forceTruth = 0;
	double volumeError = 0;  ///< found volume minus true volume [m^3]
	double forceError = 0;   ///< length of the difference of the vectors [N]
};

struct MeshToQueryOutcome
{
	std::string mesh;
	double unit = 0;
	size_t triangles = 0, spheres = 0, leaves = 0;
	double fill = 0, meanGap = 0, buildSeconds = 0, stiffness = 0;
	std::vector<std::string> repair;
	std::vector<PathStep> steps;
	std::vector<Comparison> comparisons;

	/// These four are figures of the steps in contact.
	double medianSeconds = 0, p99Seconds = 0;
	int64_t maxPairs = 0;
	double maxForce = 0;
	/// Rms of the errors, divided by the rms of the true values, so that grazing contacts do not dominate.
	double volumeRms = 0, forceRms = 0;
	/// True when the probe has touched, its force was compared with quadrature, and the error is smaller than the force.
	bool ok() const { return maxForce > 0 && !comparisons.empty() && forceRms < 1; }
};

ist::Result<MeshToQueryOutcome> runMeshToQuery(const MeshToQueryOptions& options);

/// Rows of names and values with units, in reading order.
std::vector<std::vector<std::string>> summaryRows(const MeshToQueryOutcome& outcome);
HtmlReport makeReport(const MeshToQueryOutcome& outcome);
std::string makeJson(const MeshToQueryOutcome& outcome);
}  // namespace scenes
