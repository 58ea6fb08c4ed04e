// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/StopSignals.h"

#include <atomic>
#include <mutex>

#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Platform/StopHandlers.h"

namespace devicebridge
{
namespace
{
// A signal handler can only reach global variables.
std::atomic<SteppingThread*> threads[StopSignals::kMostThreads];
std::atomic<int> lastSignal{0};
static_assert(std::atomic<SteppingThread*>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

std::mutex registering;
int registered = 0;

void stopAll(int number)
{
	lastSignal = number;
	for (std::atomic<SteppingThread*>& slot : threads)
		if (SteppingThread* thread = slot.load(std::memory_order_acquire)) thread->requestStop();
}

bool install()
{
	lastSignal = 0;
	return installStopHandlers(stopAll);
}
}  // namespace

StopSignals::StopSignals(SteppingThread& thread)
{
	const std::lock_guard<std::mutex> lock(registering);
	if (registered == 0 && !install()) return;
	for (int i = 0; i < kMostThreads && m_slot < 0; ++i)
	{
		SteppingThread* empty = nullptr;
		if (threads[i].compare_exchange_strong(empty, &thread)) m_slot = i;
	}
	if (m_slot >= 0) ++registered;
	else if (registered == 0) restoreStopHandlers();
}

StopSignals::~StopSignals()
{
	if (m_slot < 0) return;
	const std::lock_guard<std::mutex> lock(registering);
	threads[m_slot] = nullptr;
	if (--registered == 0) restoreStopHandlers();
}

int StopSignals::caught() { return lastSignal; }
}  // namespace devicebridge
