// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/AnsweringThread.h"

#include "BulletISTCollision/Core/Platform/ValueWait.h"

#include <system_error>
#include <utility>

namespace devicebridge
{
bool AnsweringThread::start(std::function<void()> begin, std::function<bool()> answer)
{
	if (m_thread.joinable()) return false;
	m_stopping = false;
	try
	{
		m_thread = std::thread([this, begin = std::move(begin), answer = std::move(answer)] {
			begin();
			loop(answer);
		});
	}
	catch (const std::system_error&)
	{
		return false;
	}
	return true;
}

void AnsweringThread::stop() noexcept
{
	m_stopping = true;
	wake();
	if (m_thread.joinable()) m_thread.join();
}

void AnsweringThread::wake() noexcept
{
	m_wake.fetch_add(1, std::memory_order_release);
	ist::wakeOne(m_wake);
}

void AnsweringThread::loop(const std::function<bool()>& answer) noexcept
{
	while (!m_stopping)
	{
		const std::uint32_t seen = m_wake.load(std::memory_order_acquire);
		if (!answer() && !m_stopping) ist::sleepWhile(m_wake, seen);
	}
	answer();
}
}  // namespace devicebridge
