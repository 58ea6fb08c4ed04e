// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"
#include "demos/scenes/Extremes/ProbePath.h"

#include <functional>
#include <string>
#include <vector>

namespace scenes
{
/// A mesh stands in a Bullet world on Bullet's own plane. A simulated hand on a simulated sigma.7 presses a steel rod on it, slides it
/// over its back and along its ear, turns it, and lets go. The 1 kHz thread of DeviceBridge owns the world (simple mode), or the world
/// steps at its own rate in a thread of its own (decoupled mode; in virtual time both take turns).
struct HapticBunnyOptions
{
	std::string mesh;  ///< file; its y axis is up
	ist::Mesh given;   ///< used when `mesh` is empty [m]
	double unit = 0;   ///< metres per unit of the file; 0: the longest side becomes 0.2 m
	int64_t spheres = 10000;
	uint64_t seed = 1;
	std::string cache;  ///< folder for trees; empty: none
	bool virtualTime = false;
	bool decoupled = false;
	double worldRate = 60;  ///< in decoupled mode [Hz]
	int comparisons = 20;   ///< instants in contact that quadrature judges
	ist::Progress progress;
	std::function<void(const std::string&)> say;  ///< messages for people
};

/// One tick. World: y up, the plane at y = 0.
struct TraceSample
{
	double time = 0;                         ///< since the hand began [s]
	double period = 0;                       ///< since the tick before [s]
	ist::Wrench hand;                        ///< what the device exerted on the hand, about the origin of the handle
	ist::Pose body, tool;                    ///< with which the query was asked
	double volume = 0;                       ///< overlap of rod and body [m^3]
	ist::Vec3 elastic;                       ///< force of the pressure field law on the rod [N]
	double volumeSigma = 0, forceSigma = 0;  ///< standard errors as the library states them; only in simple mode [m^3, N]
	int64_t pairs = 0;                       ///< over all contacts of the rod
	double queryMicroseconds = 0;            ///< all queries of the tick, that of body and plane among them
};

struct TraceComparison
{
	size_t sample = 0;
	double volumeTruth = 0;  ///< [m^3]
	ist::Vec3 forceTruth;    ///< on the rod, World [N]
	double volumeError = 0;  ///< found minus true
	double forceError = 0;   ///< length of the difference
};

/// Depth of the lowest vertex of the standing body under the plane [m].
struct Sinkage
{
	double measured = 0;
	double byTree = 0;  ///< where k V(depth) of the tree is the weight
	double byMesh = 0;  ///< where k V(depth) of the mesh itself, exactly clipped, is the weight
	double gap = 0;     ///< mean distance of the surface from the spheres, for comparison
};

struct PeriodQuantiles
{
	double p50 = 0, p99 = 0, p999 = 0, max = 0;  ///< [s]
};

/// What only decoupled mode has.
struct DecoupledFigures
{
	uint64_t worldSteps = 0, fadedTicks = 0;
	double longestModelAge = 0;           ///< of the world, as the hand knew it [s]
	ist::Vec3 toTool, toWorld, underWay;  ///< impulses that contacts gave to the tool and to the bodies, and the energy tank [N s]
	double bodyShift = 0;                 ///< of the body, over the whole session [m]
};

struct HapticBunnyOutcome
{
	std::string mesh;
	double unit = 0;
	size_t triangles = 0, spheres = 0, leaves = 0;
	double fill = 0, mass = 0, buildSeconds = 0;
	bool loadedFromCache = false, virtualTime = false;
	std::vector<std::string> repair;
	double pairStiffness = 0;  ///< of rod and body [Pa/m]

	std::vector<TraceSample> trace;
	std::vector<ProbePhase> phases;
	std::vector<std::string> phasesWithoutContact;
	std::vector<TraceComparison> comparisons;
	Sinkage sinkage;

	double medianQuery = 0, p99Query = 0;  ///< of the ticks in contact [us]
	int64_t maxPairs = 0;
	PeriodQuantiles periods;
	double meanRate = 0;  ///< [Hz]
	uint64_t overruns = 0, deviceErrors = 0;
	std::string scheduling, memory;
	double worldRate = 0;  ///< [Hz]; 0: simple mode
	DecoupledFigures decoupled;
	double maxForce = 0, maxTorque = 0;  ///< at the hand [N, N m]
	double work = 0;                     ///< that the device did on the hand [J]
	devicebridge::SafetyCounts safety;
	bool faulted = false;
	uint64_t droppedContacts = 0;        ///< queries that were refused
	double volumeRms = 0, forceRms = 0;  ///< rms of the errors over rms of the truths
	double forceDirection = 0;           ///< median angle between found and true force [rad]
	bool finite = false, cameFree = false;

	/// All finite, no safety fault, contact wherever the hand meant it, free at the end.
	bool ok() const { return finite && !faulted && phasesWithoutContact.empty() && cameFree; }
};

ist::Result<HapticBunnyOutcome> runHapticBunny(const HapticBunnyOptions& options);
}  // namespace scenes
