// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/ProgressBar.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <unistd.h>

namespace ist::tools
{
ProgressBar::ProgressBar() : m_terminal(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar()
{
	finish();
}

void ProgressBar::show(const char* stage, double fraction)
{
	if (m_stage != stage)
	{
		finish();
		m_stage = stage;
		m_stageStart = Clock::now();
		m_drawn = {};
		m_shown = -1;
	}
	fraction = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
	if (m_terminal) return draw(stage, fraction);
	const int step = static_cast<int>(fraction * 10);
	if (step <= m_shown) return;
	m_shown = step;
	std::fprintf(stderr, "%s %d %%\n", stage, step * 10);
}

void ProgressBar::draw(const char* stage, double fraction)
{
	constexpr int kBarWidth = 40;
	const Clock::time_point now = Clock::now();
	const int percent = static_cast<int>(fraction * 100);
	// The time left moves on while the share stands still.
	if (percent <= m_shown && now - m_drawn < std::chrono::milliseconds(500)) return;
	m_shown = std::max(m_shown, percent);
	m_drawn = now;
	const int done = m_shown * kBarWidth / 100;
	const std::string left = timeLeft(std::chrono::duration<double>(now - m_stageStart).count(), fraction);
	// Clears what a longer text left behind.
	std::fprintf(stderr, "\r%-8s [%s%s] %3d %%  %s\x1b[K", stage, std::string(done, '#').c_str(), std::string(kBarWidth - done, ' ').c_str(),
				 m_shown, left.c_str());
	std::fflush(stderr);
	m_open = true;
}

void ProgressBar::finish()
{
	if (m_open) std::fprintf(stderr, "\n");
	m_open = false;
}

std::string timeLeft(double elapsed, double fraction)
{
	if (fraction >= 1 || fraction < 0.01 || elapsed < 0.5) return {};
	const long seconds = static_cast<long>(std::ceil(elapsed * (1 / fraction - 1)));
	char text[48];
	if (seconds < 60)
		std::snprintf(text, sizeof text, "%ld s left", seconds);
	else if (seconds < 3600)
		std::snprintf(text, sizeof text, "%ld min %02ld s left", seconds / 60, seconds % 60);
	else
		std::snprintf(text, sizeof text, "%ld h %02ld min left", seconds / 3600, seconds / 60 % 60);
	return text;
}
}  // namespace ist::tools
