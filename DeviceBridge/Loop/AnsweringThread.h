// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

namespace devicebridge
{
/// A thread that answers questions as they come, and sleeps in between. Who asks leaves the question where the thread looks for it
/// (TripleBuffer), wakes it, and goes on.
class AnsweringThread
{
public:
	~AnsweringThread() { stop(); }

	// From the thread that set it up:
	/// On the new thread `begin` is called once, then `answer` again and again: it answers one question, and is false when none was asked.
	/// Neither throws. False, and nothing done, when it runs already or cannot be started.
	bool start(std::function<void()> begin, std::function<bool()> answer);
	/// Waits for the answer in progress and for that of the last question.
	void stop() noexcept;

	/// From any thread, after a question was asked. No lock, no allocation.
	void wake() noexcept;

private:
	void loop(const std::function<bool()>& answer) noexcept;

	std::thread m_thread;
	std::atomic<bool> m_stopping{false};
	std::atomic<std::uint32_t> m_wake{0};
};
}  // namespace devicebridge
