// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Bullet/BulletHand.h"
#include "DeviceBridge/Coupling/DeviceGains.h"
#include "DeviceBridge/Decorators/DeviceDecorator.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Loop/ThreadedForceLaw.h"
#include "demos/scenes/Scene/SceneRun.h"

#include <atomic>
#include <memory>
#include <vector>

namespace scenes
{
constexpr double kSceneTick = 1e-3;  // [s]

/// Measures the processor time of a device's calls.
class TimedDevice final : public devicebridge::DeviceDecorator
{
public:
	using DeviceDecorator::DeviceDecorator;
	devicebridge::DeviceStatus read(std::int64_t now, devicebridge::DeviceState& state) noexcept override;
	/// Processor time so far [us].
	double used() const { return m_used; }

private:
	double m_used = 0;
};

/// Writes one row per tick into memory that is allocated before the run.
class TickRecorder
{
public:
	/// `source` is null unless the hand is beside the world. All arguments must outlive this object.
	TickRecorder(devicebridge::SteppingThread& thread, const TimedDevice& device, devicebridge::Clock& clock, const ist::Pose& X_BW,
		size_t capacity, const devicebridge::BulletDecoupledSource* source);
	/// Number of rows, for any thread.
	size_t size() const { return m_count.load(std::memory_order_acquire); }
	/// Time of the first row on the clock [s]; for the end of the run, as take().
	double begun() const { return 1e-9 * static_cast<double>(m_first); }
	std::vector<SceneTick> take();

private:
	void closeLast();
	void begin(const devicebridge::DeviceState& state);
	void end();

	devicebridge::SteppingThread& m_thread;
	devicebridge::Clock& m_clock;
	const TimedDevice& m_device;
	ist::Pose m_X_BW;
	const devicebridge::BulletDecoupledSource* m_source;
	std::vector<SceneTick> m_ticks;
	SceneTick m_next;
	std::atomic<size_t> m_count{0};
	std::int64_t m_first = -1, m_last = -1;
	double m_used = 0, m_usedInDevice = 0;
	bool m_open = false;
};

/// A hand of a scene while it is played: its device, its source of contact, and its loop.
struct PlayedHand
{
	const SceneHand* scene = nullptr;
	std::unique_ptr<TimedDevice> device;
	ist::Pose X_BW;  ///< pose of the device's world
	devicebridge::CouplingGains gains;
	std::unique_ptr<devicebridge::BulletHand> parts;  ///< null: the hand has a tool
	std::unique_ptr<devicebridge::ContactSource> source;
	devicebridge::BulletContactSource* inLoop = nullptr;       ///< the source, if the hand has a tool and its loop owns the world
	devicebridge::BulletDecoupledSource* decoupled = nullptr;  ///< the source, if the hand is beside the world
	devicebridge::CouplingForceLaw coupling;
	std::unique_ptr<devicebridge::ThreadedForceLaw> law;  ///< null: the force law runs in the tick
	std::unique_ptr<devicebridge::SteppingThread> thread;
	std::unique_ptr<TickRecorder> recorder;

	PlayedHand() = default;
	~PlayedHand();
	PlayedHand(const PlayedHand&) = delete;
	PlayedHand& operator=(const PlayedHand&) = delete;
};

/// Opens the device of a hand, and makes the parts of a tracked hand. A simulated hand follows the path of the file; any other device moves
/// by itself.
std::optional<ist::Error> openHand(
	const SceneHand& scene, SceneWorld& world, devicebridge::Clock& clock, const SceneBuildOptions& build, PlayedHand& hand);

/// Result of the hand's run.
SceneHandRun runOf(PlayedHand& hand, size_t ticks, bool virtualTime);
}  // namespace scenes
