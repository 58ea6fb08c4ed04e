// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletDecoupledSource.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"
#include "TestSupport/SceneFiles/SceneWorld.h"

#include <functional>
#include <string>
#include <vector>

namespace scenes
{
struct SceneRunOptions
{
	SceneBuildOptions build;
	bool virtualTime = false;  ///< true: reproducible and as fast as possible; false: real time at 1 kHz
	/// Called in each tick of the first hand, in its thread, before the safety limits. False ends the run, as the hook `stop` does.
	std::function<bool(devicebridge::SteppingThread&, const SceneWorld&)> listener;
};

/// One tick of a scene. World B.
struct SceneTick
{
	double time = 0;    ///< time since the hand's first tick [s]
	double period = 0;  ///< time since the tick before [s]
	double threadMicroseconds =
		0;  ///< processor time of the hand's thread from the tick before to this one [us]; in one thread, that of all hands
	double deviceMicroseconds = 0;  ///< part of it in the calls of the device [us]: for a simulated hand, the time to simulate it
	ist::Pose hand, tool;           ///< pose of the handle in the device's world, and of the tool's frame P in B
	ist::Wrench wrench;             ///< wrench that the tick sent to the device, in the device's axes
	double volume = 0;              ///< overlap volume of the tool [m^3]
	int64_t pairs = 0;              ///< number of intersecting pairs of leaves
	double queryMicroseconds = 0;
	int contacts = 0;
	devicebridge::ContactAnswerCost answer;  ///< cost of the answer, when contacts have a thread of their own
};

/// Result of the hook `count`.
struct SceneContactCount
{
	std::string hand, body;
	uint64_t ticks = 0;
	double maxVolume = 0, maxForce = 0;  ///< [m^3, N]
};

/// The run of one hand.
struct SceneHandRun
{
	std::string name, device, scheduling, memory;
	double begun = 0;  ///< time of the first tick, on the clock that all hands share [s]
	std::vector<SceneTick> ticks;
	uint64_t overruns = 0, deviceErrors = 0, refusedQueries = 0, worldSteps = 0;
	devicebridge::SafetyCounts safety;
	double maxForce = 0;    ///< largest force at the hand [N]
	bool cutShort = false;  ///< whether ticks are missing at the end
	bool finite = false, faulted = false;
};

struct SceneOutcome
{
	Scene scene;
	bool virtualTime = false, stopped = false, interrupted = false;
	bool cutShort = false;  ///< true: neither stopped nor interrupted, but a hand lacks ticks, because its device gave too few samples
	std::vector<SceneHandRun> hands;  ///< in the order of the scene's hands
	std::vector<SceneContactCount> counts;
	std::vector<std::string> faults;
	std::vector<std::string> switched;   ///< what hooks switched, in the order of time: "friction off at 1.003 s"
	std::vector<std::string> unwritten;  ///< recordings that could not be written

	/// True when all values are finite, no fault remains, no tick is missing at the end, and all recordings were written.
	bool ok() const;
};

/// Makes the scene, opens its devices and runs it for its duration. With the topology one-thread all hands share one loop, which owns the
/// world; with the others each hand has a loop of its own, beside the world. In real time SIGINT and SIGTERM end it earlier, and it ends at
/// the latest five seconds after its duration. `world` receives the scene's bodies in their final state, for an evaluation of the run.
ist::Result<SceneOutcome> runScene(const Scene& scene, const SceneRunOptions& options, std::unique_ptr<SceneWorld>* world = nullptr);
}  // namespace scenes
