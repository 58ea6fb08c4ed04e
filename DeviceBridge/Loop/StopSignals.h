// SPDX-License-Identifier: Zlib
#pragma once

namespace devicebridge
{
class SteppingThread;

/// While one lives, SIGINT and SIGTERM ask a stepping thread to stop: it ends after the tick in progress and leaves its device at
/// zero. The handlers that were there before come back with the last of them; a second signal meets those. At most
/// kMostThreads at a time.
class StopSignals
{
public:
	static constexpr int kMostThreads = 16;

	explicit StopSignals(SteppingThread& thread);
	~StopSignals();
	StopSignals(const StopSignals&) = delete;
	StopSignals& operator=(const StopSignals&) = delete;

	/// False when there was no room or the handlers could not be set.
	bool active() const { return m_slot >= 0; }
	/// The signal that came while any of them lived; zero when none did.
	static int caught();

private:
	int m_slot = -1;
};
}  // namespace devicebridge
