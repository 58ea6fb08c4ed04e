// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace ist::tools
{
/// Progress on stderr: a bar on a terminal, otherwise a line every ten per cent of a stage.
class ProgressBar
{
public:
	ProgressBar();
	~ProgressBar();
	void show(const char* stage, double fraction);
	/// Ends an unfinished bar's line.
	void finish();

private:
	bool m_terminal = false;
	std::string m_stage;
	int m_shown = -1;  ///< last step printed of this stage
	bool m_open = false;
};
}  // namespace ist::tools
