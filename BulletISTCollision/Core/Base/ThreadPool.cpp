// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/ThreadPool.h"

#include <algorithm>

namespace ist
{
ThreadPool::ThreadPool(int threads)
{
	for (int worker = 1; worker < threads; ++worker) m_helpers.emplace_back([this, worker] { help(worker); });
}

ThreadPool::~ThreadPool()
{
	{
		const std::lock_guard guard(m_mutex);
		m_stop = true;
	}
	m_wake.notify_all();
	for (std::thread& helper : m_helpers) helper.join();
}

void ThreadPool::run(size_t count, size_t grain, const Task& task)
{
	if (m_helpers.empty() || count <= grain)
	{
		for (size_t i = 0; i < count; ++i) task(i, 0);
		return;
	}
	std::unique_lock lock(m_mutex);
	m_task = &task;
	m_next = 0;
	m_count = count;
	m_grain = grain;
	m_wake.notify_all();
	takeShares(lock, 0);
	m_finished.wait(lock, [this] { return m_underWay == 0; });
}

void ThreadPool::help(int worker)
{
	std::unique_lock lock(m_mutex);
	for (;;)
	{
		m_wake.wait(lock, [this] { return m_stop || m_next < m_count; });
		if (m_stop) return;
		takeShares(lock, worker);
	}
}

void ThreadPool::takeShares(std::unique_lock<std::mutex>& lock, int worker)
{
	while (m_next < m_count)
	{
		const size_t first = m_next, last = std::min(m_count, first + m_grain);
		const Task& task = *m_task;
		m_next = last;
		++m_underWay;
		lock.unlock();
		for (size_t i = first; i < last; ++i) task(i, worker);
		lock.lock();
		if (--m_underWay == 0 && m_next == m_count) m_finished.notify_one();
	}
}
}  // namespace ist
