// SPDX-License-Identifier: Zlib
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace ist
{
/// Threads that help with many short loops, asleep in between. The caller works too and waits only for shares that are under way, never
/// for a helper to show up: where other programs hold the cores, a loop takes hardly longer than it would alone.
class ThreadPool
{
public:
	/// What is done with an index; `worker` (0: the caller) tells the threads apart.
	using Task = std::function<void(size_t index, int worker)>;

	/// `threads`: the caller among them.
	explicit ThreadPool(int threads);
	~ThreadPool();
	ThreadPool(const ThreadPool&) = delete;
	ThreadPool& operator=(const ThreadPool&) = delete;

	/// Calls task for 0 .. count - 1 in shares of `grain` neighbours; returns when all are done. From one thread at a time.
	void run(size_t count, size_t grain, const Task& task);

private:
	void help(int worker);
	void takeShares(std::unique_lock<std::mutex>& lock, int worker);

	std::mutex m_mutex;  ///< of all below
	std::condition_variable m_wake, m_finished;
	const Task* m_task = nullptr;
	size_t m_next = 0, m_count = 0, m_grain = 1;
	int m_underWay = 0;  ///< shares
	bool m_stop = false;
	std::vector<std::thread> m_helpers;
};
}  // namespace ist
