// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>

#include "DeviceBridge/Loop/AnsweringThread.h"
#include "DeviceBridge/Loop/ForceLaw.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge
{
/// A force law on a separate thread, for laws that take longer than a tick may. No thread waits. The law receives the hand and step of a
/// tick, and its answer is used until the next one:
///   w(t) = c(t) + (w(t0) - c(t0)),   c: the reaction of the virtual coupling,
/// So only the part that the law adds to the coupling is delayed. The coupling's stiffness, on which stability at the hand depends, has no
/// delay. With a CouplingForceLaw inside, the hand feels the same as without this class. computedAt() returns the time of t0. So the force
/// of a law that hangs fades with its age (SafetySettings::fullUntil, zeroFrom), and returns when the law answers again.
class ThreadedForceLaw final : public ForceLaw
{
public:
	/// `law` must outlive this object. One thread at a time calls it.
	explicit ThreadedForceLaw(ForceLaw& law) : m_law(law) {}
	~ThreadedForceLaw() override { stop(); }

	// For the thread that set it up:
	/// Returns false if the thread runs already or cannot be started.
	bool start();
	/// Waits for the answer in progress. Stop the stepping thread first, because it continues to ask and would get no answer.
	void stop() noexcept;
	/// Computes one answer on the calling thread, for virtual time. Returns false if there is no question.
	bool serve() noexcept;

	// For any thread, at any time:
	/// Off: the law runs in the tick as soon as its thread has answered the open question. A question that the thread has not begun to
	/// answer is taken back. On again: the law's result of the last tick is used until its thread answers.
	void setThreaded(bool on) noexcept { m_threaded.store(on, std::memory_order_relaxed); }
	bool threaded() const noexcept { return m_threaded.load(std::memory_order_relaxed); }
	std::uint64_t answers() const noexcept { return m_answered.load(std::memory_order_relaxed); }

	// For the tick; no allocation, no lock:
	ist::Wrench handWrench(const DeviceState& hand, const ToolStep& step) noexcept override;
	std::int64_t computedAt(const DeviceState& hand) const noexcept override;

private:
	struct Question
	{
		std::uint64_t number = 0;  // 0: none; it took the place of one that was taken back
		DeviceState hand;
		ToolStep step;
	};
	struct Answer
	{
		std::uint64_t number = 0;
		ist::Wrench beyondCoupling;
		std::int64_t computedAt = 0;
	};

	void takeQuestionBack() noexcept;

	ForceLaw& m_law;
	TripleBuffer<Question> m_questions;
	TripleBuffer<Answer> m_answers;
	std::uint64_t m_asked = 0, m_settled = 0;  // numbers of the newest question, and of the newest that was answered or taken back
	bool m_triedToTakeBack = false;
	Answer m_held;  // answer in use: the newest of the thread, or the law's result in the tick; number 0: none yet
	std::atomic<bool> m_threaded{true};
	std::atomic<std::uint64_t> m_answered{0};
	AnsweringThread m_thread;
};
}  // namespace devicebridge
