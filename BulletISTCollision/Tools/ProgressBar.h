// SPDX-License-Identifier: Zlib
#pragma once

#include <chrono>
#include <string>

namespace ist::tools
{
/// Progress on stderr: on a terminal, within its width, a bar with the time left of the whole work, or of each stage where what later ones
/// will take is not known; otherwise a line every ten per cent of a stage.
class ProgressBar
{
public:
	ProgressBar();
	~ProgressBar();
	void show(const char* stage, double fraction);
	/// `whole`: the share of the time of all stages that is over.
	void show(const char* stage, double fraction, double whole);
	/// Ends an unfinished bar's line.
	void finish();

private:
	using Clock = std::chrono::steady_clock;

	void draw(const char* stage, double fraction, Clock::time_point start, const char* of);
	void list(const char* stage, double fraction);

	bool m_terminal = false;
	std::string m_stage;
	Clock::time_point m_start = Clock::now();
	Clock::time_point m_stageStart, m_drawn;
	int m_shown = -1;  ///< last step of this stage that was printed
	bool m_open = false;
};

/// Time left when `fraction` took `elapsed` seconds, to one unit below the largest: "3 s", "2 min 05 s", "1 h 10 min"; empty while
/// nothing can be said.
std::string timeLeft(double elapsed, double fraction);
}  // namespace ist::tools
