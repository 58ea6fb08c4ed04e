// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>

#include "DeviceBridge/Loop/AnsweringThread.h"
#include "DeviceBridge/Loop/ForceLaw.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge
{
/// A force law in a thread of its own, for laws that take longer than a tick may. Nobody waits: the law is given hand and step of a tick,
/// and what it answers counts until the next answer as
///   w(t) = c(t) + (w(t0) - c(t0)),   c: the reaction of the virtual coupling,
/// so that only what the law adds to the coupling lags behind, and the coupling's stiffness, on which stability at the hand depends, does
/// not: with a CouplingForceLaw inside, the hand feels what it would feel without this. computedAt() is that of t0, so a law that hangs
/// fades out with its age (SafetySettings::fullUntil, zeroFrom), and fades in when it answers again.
class ThreadedForceLaw final : public ForceLaw
{
public:
	/// `law` outlives this, and is called by one thread at a time.
	explicit ThreadedForceLaw(ForceLaw& law) : m_law(law) {}
	~ThreadedForceLaw() override { stop(); }

	// From the thread that set it up:
	/// False when it runs already or cannot be started.
	bool start();
	/// Waits for the answer in progress. The stepping thread stops first: it goes on asking, and nobody would answer.
	void stop() noexcept;
	/// One answer on the calling thread, for virtual time. False when nothing was asked.
	bool serve() noexcept;

	// From any thread, at any time:
	/// Off: the law is asked in the tick, as soon as what it was asked before is answered. On again: what it said in the last tick counts
	/// until its thread answers.
	void setThreaded(bool on) noexcept { m_threaded.store(on, std::memory_order_relaxed); }
	bool threaded() const noexcept { return m_threaded.load(std::memory_order_relaxed); }
	std::uint64_t answers() const noexcept { return m_answered.load(std::memory_order_relaxed); }

	// On the tick; no allocation, no lock:
	ist::Wrench handWrench(const DeviceState& hand, const ToolStep& step) noexcept override;
	std::int64_t computedAt(const DeviceState& hand) const noexcept override;

private:
	struct Question
	{
		std::uint64_t number = 0;
		DeviceState hand;
		ToolStep step;
	};
	struct Answer
	{
		std::uint64_t number = 0;
		ist::Wrench beyondCoupling;
		std::int64_t computedAt = 0;
	};

	ForceLaw& m_law;
	TripleBuffer<Question> m_questions;
	TripleBuffer<Answer> m_answers;
	std::uint64_t m_asked = 0;
	Answer m_held;  // what counts: the newest answer, or what the law said on the tick; number 0: nothing yet
	std::atomic<bool> m_threaded{true};
	std::atomic<std::uint64_t> m_answered{0};
	AnsweringThread m_thread;
};
}  // namespace devicebridge
