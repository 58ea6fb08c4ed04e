// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/unit/DeviceBridge/Drivers/PseudoTerminal.h"

#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

namespace devicebridge
{
/// Answers like a Magellan: identification, key and motion packets of four-bit characters.
class SpnavMagellan
{
public:
	SpnavMagellan() : m_thread([this] { live(); }) {}
	~SpnavMagellan()
	{
		m_ending = true;
		m_thread.join();
	}
	bool ok() const { return m_line.ok(); }
	const std::string& path() const { return m_line.path(); }
	void deflect(int axis, int counts) { m_axes[static_cast<std::size_t>(axis)] = counts; }
	void press(unsigned keys) { m_keys = keys; }

private:
	static std::string nibbles(unsigned value, int count)
	{
		std::string text;
		for (int i = count - 1; i >= 0; --i) text += static_cast<char>(0x30 | (value >> (4 * i) & 0xF));
		return text;
	}
	void live()
	{
		unsigned keys = 0;
		while (!m_ending)
		{
			const std::string asked = m_line.receive(10);
			if (asked.find("vQ") != std::string::npos) m_line.send("vMAGELLAN  Version 6.70  3Dconnexion GmbH\r"), m_known = true;
			if (!m_known) continue;
			std::string motion = "d";
			for (const auto& axis : m_axes) motion += nibbles(static_cast<unsigned>(0x8000 + axis), 4);
			m_line.send(motion + "\r");
			if (keys != m_keys) m_line.send("k" + nibbles(m_keys, 3) + "\r");
			keys = m_keys;
		}
	}

	PseudoTerminal m_line;
	std::array<std::atomic<int>, 6> m_axes{};
	std::atomic<unsigned> m_keys{0};
	std::atomic<bool> m_ending{false};
	bool m_known = false;
	std::thread m_thread;
};

/// The real daemon in a folder of its own, because Debian's uses a path relative to its start folder.
class SpnavDaemon
{
public:
	explicit SpnavDaemon(const std::string& serial)
	{
		char folder[] = "/tmp/spnavXXXXXX";
		if (!mkdtemp(folder)) return;
		m_folder = folder;
		std::filesystem::create_directory(m_folder + "/run");
		std::ofstream(m_folder + "/rc") << "serial = " << serial << "\ndead-zone = 0\nsensitivity = 1.0\n";
		m_child = fork();
		if (m_child == 0)
		{
			const bool moved = chdir(m_folder.c_str()) == 0;
			if (moved) execl("/usr/bin/spacenavd", "spacenavd", "-d", "-c", "rc", "-l", "log", static_cast<char*>(nullptr));
			_exit(127);
		}
		setenv("SPNAV_SOCKET", socket().c_str(), 1);
	}
	~SpnavDaemon()
	{
		end();
		unsetenv("SPNAV_SOCKET");
		std::error_code failure;
		std::filesystem::remove_all(m_folder, failure);
	}
	static bool installed() { return std::filesystem::exists("/usr/bin/spacenavd"); }
	std::string socket() const { return m_folder + "/run/spnav.sock"; }
	void end()
	{
		if (m_child > 0) kill(m_child, SIGKILL), waitpid(m_child, nullptr, 0);
		m_child = -1;
	}

private:
	std::string m_folder;
	pid_t m_child = -1;
};
}  // namespace devicebridge
