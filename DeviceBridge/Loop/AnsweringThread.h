// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

namespace devicebridge
{
/// A thread that answers questions as they come and sleeps in between. The caller writes its question to where the thread reads it
/// (TripleBuffer), wakes the thread and continues.
class AnsweringThread
{
public:
	~AnsweringThread() { stop(); }

	// For the thread that set it up:
	/// Starts the thread. The thread calls `begin` once, then `answer` repeatedly. `answer` answers one question, and returns false if
	/// there is none. Neither may throw. Returns false and does nothing if the thread runs already or cannot be started.
	bool start(std::function<void()> begin, std::function<bool()> answer);
	/// Waits for the answer in progress and for the answer to the last question.
	void stop() noexcept;

	/// Wakes the thread after a question was asked. Any thread may call it. No lock, no allocation.
	void wake() noexcept;

private:
	void loop(const std::function<bool()>& answer) noexcept;

	std::thread m_thread;
	std::atomic<bool> m_stopping{false};
	std::atomic<std::uint32_t> m_wake{0};
};
}  // namespace devicebridge
