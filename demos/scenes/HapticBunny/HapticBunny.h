// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"
#include "demos/scenes/Extremes/ProbePath.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace scenes
{
/// A mesh stands in a Bullet world on Bullet's own plane. A simulated hand on a simulated sigma.7 presses a steel rod on it, slides it
/// over its back and along its ear, turns it, and leaves. In simple mode the 1 kHz thread of DeviceBridge owns the world. In decoupled
/// mode the world steps at its own rate in its own thread; in virtual time both take turns.
struct HapticBunnyOptions
{
	std::string mesh;  ///< mesh file; its y axis points up, unless `up` turns it
	std::optional<ist::UpAxes> up;
	ist::Mesh given;  ///< used when `mesh` is empty [m]
	double unit = 0;  ///< unit of the file [m]; 0: the longest side becomes 0.2 m
	int64_t spheres = 10000;
	uint64_t seed = 1;
	std::string cache;  ///< folder for trees; empty: trees are not stored
	bool virtualTime = false;
	bool decoupled = false;
	double worldRate = 60;  ///< rate of the world in decoupled mode [Hz]
	int comparisons = 20;   ///< number of instants in contact that are compared with quadrature
	ist::Progress progress;
	std::function<void(const std::string&)> say;  ///< receives messages for the user
};

/// One tick. In World, y points up and the plane is y = 0.
struct TraceSample
{
	double time = 0;                         ///< time since the hand began [s]
	double period = 0;                       ///< time since the tick before [s]
	ist::Wrench hand;                        ///< wrench of the device on the hand, about the origin of the handle
	ist::Pose body, tool;                    ///< poses of the query
	double volume = 0;                       ///< overlap of rod and body [m^3]
	ist::Vec3 elastic;                       ///< force of the pressure field law on the rod [N]
	double volumeSigma = 0, forceSigma = 0;  ///< standard errors that the library reports; only in simple mode [m^3, N]
	int64_t pairs = 0;                       ///< pairs of leaves over all contacts of the rod
	double queryMicroseconds = 0;            ///< time of all queries of the tick, including that of body and plane [us]
};

struct TraceComparison
{
	size_t sample = 0;
	double volumeTruth = 0;  ///< [m^3]
	ist::Vec3 forceTruth;    ///< true force on the rod, World [N]
	double volumeError = 0;  ///< found volume minus true volume
	double forceError = 0;   ///< length of the difference of the forces
};

/// Depth of the lowest vertex of the standing body under the plane [m].
struct Sinkage
{
	double measured = 0;
	double byTree = 0;  ///< depth at which k V(depth) of the tree equals the weight
	double byMesh = 0;  ///< depth at which k V(depth) of the mesh itself, exactly clipped, equals the weight
	double gap = 0;     ///< mean distance of the surface from the spheres, for comparison
};

struct PeriodQuantiles
{
	double p50 = 0, p99 = 0, p999 = 0, max = 0;  ///< [s]
};

/// Figures of decoupled mode.
struct DecoupledFigures
{
	uint64_t worldSteps = 0, fadedTicks = 0;
	double longestModelAge = 0;  ///< largest age of the world's model in the hand's thread [s]
	/// impulses that contacts gave to the tool and to the bodies, and the part that is not yet applied [N s]
	ist::Vec3 toTool, toWorld, underWay;
	double bodyShift = 0;  ///< displacement of the body over the whole run [m]
};

struct HapticBunnyOutcome
{
	std::string mesh;
	double unit = 0;
	size_t triangles = 0, spheres = 0, leaves = 0;
	double fill = 0, mass = 0, buildSeconds = 0;
	bool loadedFromCache = false, virtualTime = false;
	std::vector<std::string> repair;
	double pairStiffness = 0;  ///< stiffness of the pair of rod and body [Pa/m]

	std::vector<TraceSample> trace;
	std::vector<ProbePhase> phases;
	std::vector<std::string> phasesWithoutContact;
	std::vector<TraceComparison> comparisons;
	Sinkage sinkage;

	double medianQuery = 0, p99Query = 0;  ///< query times of the ticks in contact [us]
	int64_t maxPairs = 0;
	PeriodQuantiles periods;
	double meanRate = 0;  ///< mean rate of the ticks [Hz]
	uint64_t overruns = 0, deviceErrors = 0;
	std::string scheduling, memory;
	double worldRate = 0;  ///< rate of the world [Hz]; 0: simple mode
	DecoupledFigures decoupled;
	double maxForce = 0, maxTorque = 0;  ///< largest force and torque at the hand [N, N m]
	double work = 0;                     ///< work of the device on the hand [J]
	devicebridge::SafetyCounts safety;
	bool faulted = false;
	uint64_t droppedContacts = 0;        ///< number of queries that were refused
	double volumeRms = 0, forceRms = 0;  ///< rms of the errors, divided by the rms of the true values
	double forceDirection = 0;           ///< median angle between the found and the true force [rad]
	bool finite = false, cameFree = false;

	/// True when all values are finite, there is no safety fault, every phase that should have contact has it, and the rod is free at the
	/// end.
	bool ok() const { return finite && !faulted && phasesWithoutContact.empty() && cameFree; }
};

ist::Result<HapticBunnyOutcome> runHapticBunny(const HapticBunnyOptions& options);
}  // namespace scenes
