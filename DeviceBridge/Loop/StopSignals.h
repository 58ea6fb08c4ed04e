// SPDX-License-Identifier: Zlib
#pragma once

namespace devicebridge
{
class SteppingThread;

/// During its lifetime, SIGINT and SIGTERM (on Windows Ctrl-C, Ctrl-Break, a closed console and the end of the session) request a stepping
/// thread to stop: the thread ends after the tick in progress and leaves its device at zero. The previous handlers are restored when the
/// last object is destroyed. A second signal calls those. At most kMostThreads objects exist at a time.
class StopSignals
{
public:
	static constexpr int kMostThreads = 16;

	explicit StopSignals(SteppingThread& thread);
	~StopSignals();
	StopSignals(const StopSignals&) = delete;
	StopSignals& operator=(const StopSignals&) = delete;

	/// Whether the handlers are set and a place was free.
	bool active() const { return m_slot >= 0; }
	/// The signal that came during the lifetime of any of these objects; zero if none came.
	static int caught();

private:
	int m_slot = -1;
};
}  // namespace devicebridge
