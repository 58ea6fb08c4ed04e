// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Recording.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

namespace browser
{
/// The recording of a hand on a straight way, as a file that goes with it.
class RecordedHand
{
public:
	RecordedHand(const ist::Vec3& way, int ticks)
		: m_path((std::filesystem::temp_directory_path() / ("hand" + std::to_string(std::random_device()()) + ".istdrec")).string())
	{
		devicebridge::Recording recording;
		recording.info.workspaceRadius = 0.1;
		for (int i = 0; i < ticks; ++i)
		{
			devicebridge::RecordedTick tick;
			tick.now = tick.state.sampledAt = 1'000'000LL * i;
			tick.state.sequence = std::uint64_t(i + 1);
			tick.state.X_WH.translation = (double(i) / (ticks - 1)) * way;
			recording.ticks.push_back(tick);
		}
		EXPECT_TRUE(devicebridge::saveRecording(recording, m_path));
	}
	~RecordedHand()
	{
		std::error_code ignored;
		std::filesystem::remove(m_path, ignored);
	}
	RecordedHand(const RecordedHand&) = delete;
	RecordedHand& operator=(const RecordedHand&) = delete;
	std::string address() const { return "replay:" + m_path; }

private:
	std::string m_path;
};
}  // namespace browser
