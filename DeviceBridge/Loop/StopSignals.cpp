// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/StopSignals.h"

#include <atomic>
#include <csignal>
#include <mutex>

#include "DeviceBridge/Loop/SteppingThread.h"

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

#if defined(__unix__) || defined(__APPLE__)
struct sigaction before[2];
constexpr int kSignals[2] = {SIGINT, SIGTERM};

void restore()
{
	for (int i = 0; i < 2; ++i) sigaction(kSignals[i], &before[i], nullptr);
}

void onStopSignal(int number)
{
	lastSignal = number;
	for (std::atomic<SteppingThread*>& slot : threads)
		if (SteppingThread* thread = slot.load(std::memory_order_acquire)) thread->requestStop();
	for (int i = 0; i < 2; ++i)
		if (kSignals[i] == number) sigaction(number, &before[i], nullptr);
}

bool install()
{
	struct sigaction action = {};
	action.sa_handler = onStopSignal;
	action.sa_flags = SA_RESTART;
	lastSignal = 0;
	return sigaction(SIGINT, &action, &before[0]) == 0 && sigaction(SIGTERM, &action, &before[1]) == 0;
}
#else
bool install() { return false; }
void restore() {}
#endif
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
	else if (registered == 0) restore();
}

StopSignals::~StopSignals()
{
	if (m_slot < 0) return;
	const std::lock_guard<std::mutex> lock(registering);
	threads[m_slot] = nullptr;
	if (--registered == 0) restore();
}

int StopSignals::caught() { return lastSignal; }
}  // namespace devicebridge
