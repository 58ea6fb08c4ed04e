// SPDX-License-Identifier: Zlib
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <random>
#include <thread>

#include "DeviceBridge/Drivers/Glove/GloveFrames.h"
#include "tests/unit/DeviceBridge/Drivers/PseudoTerminal.h"

namespace devicebridge
{
/// A CyberGlove on a pseudo terminal that sends the same values until set().
class SerialGlove
{
public:
	explicit SerialGlove(int sensors) : m_sensors(sensors), m_thread([this] { live(); }) {}
	~SerialGlove()
	{
		m_ending = true;
		m_thread.join();
	}
	const std::string& path() const { return m_line.path(); }
	void set(const GloveValues& values)
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_values = values;
	}
	std::atomic<bool> silent{false}, noisy{false}, unplugged{false};
	std::atomic<int> stops{0};

private:
	static GloveValues valuesAtFirst()
	{
		GloveValues values;
		values.fill(100);
		return values;
	}
	void live()
	{
		bool streaming = false;
		std::mt19937 random(1);
		while (!m_ending)
		{
			const std::string asked = m_line.receive(2);
			for (const char c : asked)
			{
				if (c == '\x03') streaming = false, ++stops;
				if (c == 'S') streaming = true;
			}
			if (unplugged) m_line.pull();
			if (unplugged) return;
			if (!streaming || silent) continue;
			std::string frame = "S";
			{
				const std::lock_guard<std::mutex> lock(m_mutex);
				for (int i = 0; i < kGloveSensors; ++i)
					if (m_sensors == 22 || !isDistal(i)) frame += static_cast<char>(m_values[static_cast<std::size_t>(i)]);
			}
			frame += '\0';
			if (noisy && random() % 3 == 0) frame.erase(random() % frame.size(), 1 + random() % 3);
			m_line.send(frame);
		}
	}

	PseudoTerminal m_line;
	int m_sensors;
	std::mutex m_mutex;
	GloveValues m_values = valuesAtFirst();
	std::atomic<bool> m_ending{false};
	std::thread m_thread;
};

/// Skips its tests where there are no serial lines without a device: every POSIX system has them, Windows only what Wine makes.
class GloveOnALine : public testing::Test
{
protected:
	void SetUp() override
	{
		if (!PseudoTerminal().ok()) GTEST_SKIP() << "needs serial lines without a device: tests/unit/wine_serial_lines.py WINE PROGRAM";
	}
};
}  // namespace devicebridge
