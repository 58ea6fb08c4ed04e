// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletDecoupledSource.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"
#include "TestSupport/SceneFiles/SceneWorld.h"

#include <string>
#include <vector>

namespace scenes
{
struct SceneRunOptions
{
	SceneBuildOptions build;
	bool virtualTime = false;  ///< as fast as possible and reproducible, instead of at 1 kHz
};

/// One tick of a scene. World B.
struct SceneTick
{
	double time = 0;                ///< since the first tick [s]
	double period = 0;              ///< since the tick before [s]
	double threadMicroseconds = 0;  ///< on a processor, of the hand's thread, from the tick before to this one
	double deviceMicroseconds = 0;  ///< of this, in the calls of the device: what a simulated hand takes to simulate
	ist::Pose hand, tool;           ///< of the handle in the device's world, and of the tool's frame P in B
	ist::Wrench wrench;             ///< what the tick sent to the device, in the device's axes
	double volume = 0;              ///< overlap of the tool [m^3]
	int64_t pairs = 0;              ///< intersecting leaves
	double queryMicroseconds = 0;
	int contacts = 0;
	devicebridge::ContactAnswerCost answer;  ///< where the contacts have a thread of their own
};

/// What the hook `count` found.
struct SceneContactCount
{
	std::string body;
	uint64_t ticks = 0;
	double maxVolume = 0, maxForce = 0;  ///< [m^3, N]
};

struct SceneOutcome
{
	Scene scene;
	bool virtualTime = false, stopped = false, interrupted = false;
	bool cutShort = false;  ///< neither stopped nor interrupted, and still without all its ticks: the device gave too few samples
	std::vector<SceneTick> ticks;
	std::vector<SceneContactCount> counts;
	std::vector<std::string> faults;
	std::vector<std::string> unwritten;  ///< recordings that could not be written
	uint64_t overruns = 0, deviceErrors = 0, refusedQueries = 0, worldSteps = 0;
	devicebridge::SafetyCounts safety;
	std::string scheduling, memory, device;
	double maxForce = 0;  ///< at the hand [N]
	bool finite = false, faulted = false;

	/// All finite, no fault that stays, nothing missing at the end, and all recordings written.
	bool ok() const { return finite && !faulted && !cutShort && unwritten.empty(); }
};

/// Makes the scene, opens its device and runs it for its duration; in real time SIGINT and SIGTERM end it earlier, and five seconds after
/// its time it ends in any case. `world` receives the scene's bodies as they were left, for those who judge the run.
ist::Result<SceneOutcome> runScene(const Scene& scene, const SceneRunOptions& options, std::unique_ptr<SceneWorld>* world = nullptr);
}  // namespace scenes
