// SPDX-License-Identifier: Zlib
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "DeviceBridge/Drivers/Glove/GloveLink.h"
#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
/// The calibration of a glove in steps, without a user interface: a person holds the flat hand, then the fist, and a file is written.
/// The owner shows order(), calls confirm() when the person holds the pose, and calls update() all the time.
class GloveFitting
{
public:
	enum class State
	{
		Pose,       ///< waits for confirm()
		Measuring,  ///< the person holds still
		Written,    ///< the file is written
		Failed      ///< complaint() says why
	};

	/// Opens the glove at an address, which takes up to 2.3 s; the calibration that it names is ignored. Errors: the device is no glove
	/// (with the way to calibrate it), the glove does not open, the file cannot be written.
	static ist::Result<std::unique_ptr<GloveFitting>> begin(const std::string& address, std::string file);

	State state() const noexcept { return m_state; }
	/// What the person does now, as an order; when the file is written, the address that uses it.
	std::string order() const;
	const std::string& complaint() const noexcept { return m_complaint; }
	int sensors() const noexcept { return m_glove.sensors(); }
	/// The address of the glove with the file that was written.
	const std::string& calibratedAddress() const noexcept { return m_calibrated; }

	/// The pose is held. What the glove has sent before counts no more.
	void confirm();
	/// Takes the frames that have arrived and does not wait. A pose takes 100 frames, 1.1 s of a glove at 90 Hz.
	State update();

private:
	GloveFitting(GloveSettings settings, const std::string& address, std::string file);
	void take(const GloveValues& values);
	void write();
	State fail(std::string why);

	RealClock m_clock;
	GloveLink m_glove;
	std::string m_file, m_calibrated, m_complaint;
	State m_state = State::Pose;
	int m_pose = 0, m_frames = 0;
	std::array<double, kGloveSensors> m_sum{};
	GloveValues m_held[2] = {};
	std::int64_t m_heard = 0;  // time of the last frame [ns]
};
}  // namespace devicebridge
