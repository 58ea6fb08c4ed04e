// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Base/Vec3.h"
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"
#include "demos/scenes/Bodies/RodProbe.h"
#include "demos/scenes/Pages/HtmlReport.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace scenes
{
/// A rod moves over a mesh at 1 kHz along a prescribed path, so that the contact does not stop it. It presses, slides fast, leaves the
/// surface, returns elsewhere and slides slowly. In each tick the force of the trees is compared with that of the continuum
/// (ContinuumGrid) at the same pose.
struct ContinuityOptions
{
	std::string mesh;  ///< mesh file; y points up, unless `up` turns it; its longest side is scaled to 0.2 m
	std::optional<ist::UpAxes> up;
	int64_t spheres = 10000, rodSpheres = 4000;
	std::string cache;        ///< folder for trees; empty: trees are not stored
	double spacing = 2.5e-4;  ///< spacing of the grid [m]
	double depth = 0.004;     ///< depth to which the rod is pressed [m]
	ist::Progress progress;
	std::function<void(const std::string&)> say;
};

struct ContinuityTick
{
	double time = 0;         ///< [s]
	ist::Vec3 center;        ///< centre of the rod, in the mesh's frame [m]
	ist::Vec3 found, truth;  ///< force on the rod for k = 1 Pa/m [m^3]
	double foundVolume = 0, trueVolume = 0;
	int64_t pairs = 0;
};

struct ContinuityOutcome
{
	std::string mesh;
	size_t spheres = 0;
	std::vector<ContinuityTick> ticks;
	std::vector<ProbePhase> phases;
	double largestForce = 0;  ///< largest force of the continuum
	double forceError = 0;    ///< rms of the difference over rms of the truth
	/// Change from tick to tick: largest difference to that of the continuum, and its 99th percentile, both divided by the largest force.
	double changeError = 0, changeError99 = 0;
	double largestChange = 0;  ///< largest change of the continuum itself, divided by the largest force
	/// Noise while sliding at 5 cm/s: rms of the force above 50 Hz in excess of that of the continuum, divided by the mean force.
	double excess = 0;
	double powerFound = 0, powerTruth = 0;  ///< rms above 50 Hz of both forces, divided by the mean force

	/// True when the rod has met the body. Otherwise there is no force to compare with.
	bool ok() const { return largestForce > 0; }
};

ist::Result<ContinuityOutcome> runContinuity(const ContinuityOptions& options);

std::vector<std::vector<std::string>> summaryRows(const ContinuityOutcome& outcome);
HtmlReport makeReport(const ContinuityOutcome& outcome);
std::string makeJson(const ContinuityOutcome& outcome);

/// Power of `values` at frequencies above `cut`: the mean square of this part of the signal, under a Hann window. `rate` is the sampling
/// rate.
double powerAbove(const std::vector<double>& values, double rate, double cut);
}  // namespace scenes
