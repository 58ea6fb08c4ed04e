// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/ProgressBar.h"

#include <algorithm>
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
		m_shown = -1;
	}
	const int percent = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * 100);
	const int step = m_terminal ? percent : percent / 10;
	if (step <= m_shown) return;
	m_shown = step;
	if (!m_terminal)
	{
		std::fprintf(stderr, "%s %d %%\n", stage, step * 10);
		return;
	}
	const int width = 40, done = percent * width / 100;
	std::fprintf(stderr, "\r%-8s [%s%s] %3d %%", stage, std::string(done, '#').c_str(), std::string(width - done, ' ').c_str(), percent);
	std::fflush(stderr);
	m_open = true;
}

void ProgressBar::finish()
{
	if (m_open) std::fprintf(stderr, "\n");
	m_open = false;
}
}  // namespace ist::tools
