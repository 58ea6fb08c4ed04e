// SPDX-License-Identifier: Zlib
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace ist::tools
{
/// Progress on stderr. On a terminal it is a bar within the terminal's width. It shows the time left for the whole work, or for each
/// stage if the time of later ones is not known. Otherwise it is a line for every ten per cent of a stage.
class ProgressBar
{
public:
	ProgressBar();
	~ProgressBar();
	void show(const char* stage, double fraction);
	/// `whole`: share of the time of all stages that has passed.
	void show(const char* stage, double fraction, double whole);
	/// Ends the line of an unfinished bar.
	void finish();

private:
	using Clock = std::chrono::steady_clock;

	void draw(const char* stage, double fraction, Clock::time_point start, const char* of);
	void list(const char* stage, double fraction);

	bool m_terminal = false;
	std::string m_stage;
	Clock::time_point m_start = Clock::now();
	Clock::time_point m_stageStart, m_drawn;
	int m_shown = -1;                     ///< last per cent of this stage that was drawn
	std::map<std::string, int> m_listed;  ///< last tenth of each stage that was written
	bool m_open = false;
};

/// Time left if `fraction` took `elapsed` seconds, to one unit below the largest: "3 s", "2 min 05 s", "1 h 10 min". Empty while no
/// estimate is possible.
std::string timeLeft(double elapsed, double fraction);
}  // namespace ist::tools
