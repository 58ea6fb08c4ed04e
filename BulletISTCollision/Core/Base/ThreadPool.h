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
/// Thread pool for many short loops; its threads sleep in between. The caller works too, and waits only for shares that have begun, never
/// for a worker to wake up. So when other programs hold the cores, a loop takes hardly longer than on the caller alone.
class ThreadPool
{
public:
	/// Function called for each index; `worker` is the number of the thread (0: the caller).
	using Task = std::function<void(size_t index, int worker)>;

	/// `threads`: number of threads, the caller included.
	explicit ThreadPool(int threads);
	~ThreadPool();
	ThreadPool(const ThreadPool&) = delete;
	ThreadPool& operator=(const ThreadPool&) = delete;

	/// Calls task for 0 .. count - 1 in shares of `grain` consecutive indices, and returns when all are done. From one thread at a time.
	void run(size_t count, size_t grain, const Task& task);

private:
	void help(int worker);
	void takeShares(std::unique_lock<std::mutex>& lock, int worker);

	std::mutex m_mutex;  ///< guards all members below
	std::condition_variable m_wake, m_finished;
	const Task* m_task = nullptr;
	size_t m_next = 0, m_count = 0, m_grain = 1;
	int m_underWay = 0;  ///< number of shares that have begun
	bool m_stop = false;
	std::vector<std::thread> m_helpers;
};
}  // namespace ist
