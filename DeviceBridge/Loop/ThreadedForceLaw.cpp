// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/ThreadedForceLaw.h"

namespace devicebridge
{
namespace
{
ist::Wrench reaction(const ToolStep& step) { return -1.0 * step.coupling; }
}  // namespace

ist::Wrench ThreadedForceLaw::handWrench(const DeviceState& hand, const ToolStep& step) noexcept
{
	if (m_answers.fetch())
	{
		m_held = m_answers.readable();
		m_settled = m_held.number;
	}
	if (!threaded()) takeQuestionBack();
	const bool free = m_settled == m_asked;
	if (!threaded() && free)
	{
		const ist::Wrench wrench = m_law.handWrench(hand, step);
		m_held = {1, wrench - reaction(step), m_law.computedAt(hand)};
		return wrench;
	}
	if (free)
	{
		Question& question = m_questions.writable();
		question.number = ++m_asked;
		question.hand = hand;
		question.step = step;
		m_triedToTakeBack = false;
		m_questions.publish();
		m_thread.wake();
	}
	return m_held.number == 0 ? ist::Wrench() : reaction(step) + m_held.beyondCoupling;
}

/// Replaces a question that no thread has begun with by an empty one, because its thread may have been stopped. If a thread has begun with
/// it, its answer will come, and one try is enough.
void ThreadedForceLaw::takeQuestionBack() noexcept
{
	if (m_settled == m_asked || m_triedToTakeBack) return;
	m_triedToTakeBack = true;
	m_questions.writable().number = 0;
	if (m_questions.publish()) m_settled = m_asked;
}

std::int64_t ThreadedForceLaw::computedAt(const DeviceState& hand) const noexcept
{
	// Before the first answer the wrench is zero and not late, so that there is no fault.
	return m_held.number == 0 ? hand.sampledAt : m_held.computedAt;
}

bool ThreadedForceLaw::serve() noexcept
{
	if (!m_questions.fetch()) return false;
	const Question& question = m_questions.readable();
	if (question.number == 0) return false;
	Answer& answer = m_answers.writable();
	answer.number = question.number;
	answer.beyondCoupling = m_law.handWrench(question.hand, question.step) - reaction(question.step);
	answer.computedAt = m_law.computedAt(question.hand);
	m_answers.publish();
	m_answered.fetch_add(1, std::memory_order_relaxed);
	return true;
}

bool ThreadedForceLaw::start()
{
	return m_thread.start([] {}, [this] { return serve(); });
}

void ThreadedForceLaw::stop() noexcept { m_thread.stop(); }
}  // namespace devicebridge
