// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/ProgressBar.h"

#include "BulletISTCollision/Tools/Platform/Terminal.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ist::tools
{
namespace
{
/// The line must fit into the width. Otherwise the terminal would wrap it, and the next line could not replace it.
std::string barLine(const char* stage, int percent, const std::string& left, const char* of, int width)
{
	constexpr int kWidestBar = 40, kNarrowestBar = 10, kBeside = 49;  // kBeside: columns beside the bar, with the longest time
	const int bar = std::min(kWidestBar, width - 1 - kBeside), done = bar * percent / 100;
	char text[32];
	std::snprintf(text, sizeof text, "%-8s ", stage);
	std::string line = text;
	if (bar >= kNarrowestBar) line += "[" + std::string(size_t(done), '#') + std::string(size_t(bar - done), ' ') + "] ";
	std::snprintf(text, sizeof text, "%3d %%", percent);
	line += text;
	if (!left.empty()) line += "  " + left + of;
	return line.substr(0, size_t(width - 1));
}
}  // namespace

ProgressBar::ProgressBar() : m_terminal(hasTerminal()) {}

ProgressBar::~ProgressBar() { finish(); }

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
	m_terminal ? draw(stage, fraction, m_stageStart, " of this stage") : list(stage, fraction);
}

void ProgressBar::show(const char* stage, double fraction, double whole)
{
	if (!m_terminal) return show(stage, fraction);
	// A new stage is shown at once.
	if (m_stage != stage) m_drawn = {};
	m_stage = stage;
	draw(stage, std::isfinite(whole) ? std::clamp(whole, 0.0, 1.0) : 0.0, m_start, "");
}

void ProgressBar::list(const char* stage, double fraction)
{
	const int step = static_cast<int>(fraction * 10);
	int& listed = m_listed.emplace(stage, -1).first->second;
	if (step <= listed) return;
	listed = step;
	std::fprintf(stderr, "%s %d %%\n", stage, step * 10);
}

void ProgressBar::draw(const char* stage, double fraction, Clock::time_point start, const char* of)
{
	const Clock::time_point now = Clock::now();
	const int percent = static_cast<int>(fraction * 100);
	// The time left is updated even while the percentage stays the same.
	if (percent <= m_shown && now - m_drawn < std::chrono::milliseconds(500)) return;
	m_shown = std::max(m_shown, percent);
	m_drawn = now;
	const std::string left = timeLeft(std::chrono::duration<double>(now - start).count(), fraction);
	// \x1b[K clears the rest of a longer former text.
	std::fprintf(stderr, "\r%s\x1b[K", barLine(stage, m_shown, left, of, terminalWidth()).c_str());
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
	if (seconds < 60) std::snprintf(text, sizeof text, "%ld s left", seconds);
	else if (seconds < 3600) std::snprintf(text, sizeof text, "%ld min %02ld s left", seconds / 60, seconds % 60);
	else std::snprintf(text, sizeof text, "%ld h %02ld min left", seconds / 3600, seconds / 60 % 60);
	return text;
}
}  // namespace ist::tools
