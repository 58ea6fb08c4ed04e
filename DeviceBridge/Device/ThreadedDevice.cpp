// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Device/ThreadedDevice.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "DeviceBridge/Platform/RealTimePriority.h"
#include "DeviceBridge/Timing/Clock.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge
{
namespace
{
constexpr std::int64_t kLongestLife = 1'000'000'000;  // longest life of a command [ns]
constexpr int kPriority = 79;                         // priority under SCHED_FIFO, one below the stepping thread

std::int64_t realNow() noexcept { return RealClock().now(); }

struct TimedCommand
{
	DeviceCommand command;
	std::int64_t deadline = 0;  // time on a RealClock [ns]
};
}  // namespace

struct ThreadedDevice::Worker
{
	enum class Phase
	{
		Connecting,
		Waiting,  // until the first sample
		Running,
		Ended
	};

	std::unique_ptr<DeviceLink> link;
	TripleBuffer<DeviceSample> samples;
	TripleBuffer<TimedCommand> commands;
	std::atomic<bool> ending{false};
	std::atomic<DeviceStatus> status{DeviceStatus::NotOpen};
	std::thread thread;

	std::mutex mutex;  // guards the members below; read() and write() never lock it
	std::condition_variable changed;
	Phase phase = Phase::Connecting;
	DeviceInfo info;
	std::string complaint;

	void run() noexcept;
	bool waitFor(std::int64_t patience, bool (*reached)(Phase));

private:
	bool connect() noexcept;
	DeviceCommand currentCommand() noexcept;
	DeviceLink::Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept;
	void stepTo(Phase next) noexcept;
	void complain(std::string why) noexcept;
};

void ThreadedDevice::Worker::stepTo(Phase next) noexcept
{
	const std::lock_guard<std::mutex> lock(mutex);
	phase = next;
	changed.notify_all();
}

void ThreadedDevice::Worker::complain(std::string why) noexcept
{
	const std::lock_guard<std::mutex> lock(mutex);
	complaint = std::move(why);
}

bool ThreadedDevice::Worker::waitFor(std::int64_t patience, bool (*reached)(Phase))
{
	std::unique_lock<std::mutex> lock(mutex);
	return changed.wait_for(lock, std::chrono::nanoseconds(patience), [&] { return reached(phase); });
}

bool ThreadedDevice::Worker::connect() noexcept
{
	auto found = link->connect();
	if (!found)
	{
		complain(found.error().message);
		return false;
	}
	// A driver without processor time would hold an old force, so it requests real time. If that is refused, the driver runs nevertheless.
	if (found.value().actuated != 0) askForRealTimePriority(kPriority);
	{
		const std::lock_guard<std::mutex> lock(mutex);
		info = std::move(found).value();
	}
	stepTo(Phase::Waiting);
	return true;
}

DeviceCommand ThreadedDevice::Worker::currentCommand() noexcept
{
	commands.fetch();
	DeviceCommand command = commands.readable().command;
	if (realNow() < commands.readable().deadline) return command;
	command.wrench = {};
	command.gripForce = 0;
	return command;
}

DeviceLink::Event ThreadedDevice::Worker::exchange(const DeviceCommand& command, DeviceSample& sample) noexcept
{
	const DeviceLink::Event event = link->exchange(command, sample);
	if (event == DeviceLink::Event::Sample && sample.state.sampledAt == 0) sample.state.sampledAt = realNow();
	return event;
}

void ThreadedDevice::Worker::run() noexcept
{
	if (connect())
	{
		std::uint64_t sequence = 0;
		DeviceLink::Event event = DeviceLink::Event::Nothing;
		while (!ending.load(std::memory_order_acquire) && event != DeviceLink::Event::Lost)
		{
			DeviceSample sample;
			event = exchange(currentCommand(), sample);
			if (event != DeviceLink::Event::Sample) continue;
			sample.state.sequence = ++sequence;
			samples.write(sample);
			if (sequence > 1) continue;
			status.store(DeviceStatus::Ok, std::memory_order_release);
			stepTo(Phase::Running);
		}
		if (event == DeviceLink::Event::Lost) complain(link->complaint());
		else
		{
			DeviceSample last;
			link->exchange({}, last);
		}
	}
	status.store(DeviceStatus::Disconnected, std::memory_order_release);  // a thread that reads it also finds the complaint
	link->disconnect();
	stepTo(Phase::Ended);
}

ThreadedDevice::ThreadedDevice(std::unique_ptr<DeviceLink> link) : m_link(std::move(link)) {}

ThreadedDevice::~ThreadedDevice() { close(); }

bool ThreadedDevice::takeInfo() noexcept
{
	const std::lock_guard<std::mutex> lock(m_worker->mutex);
	if (!m_hasInfo) m_info = m_worker->info;
	return m_hasInfo = true;
}

DeviceStatus ThreadedDevice::open() noexcept
{
	close();
	if (!m_link) return DeviceStatus::Refused;
	try
	{
		m_worker = std::make_shared<Worker>();
		m_worker->link = std::move(m_link);
		m_worker->thread = std::thread([worker = m_worker] { worker->run(); });
	}
	catch (const std::exception&)
	{
		if (m_worker) m_link = std::move(m_worker->link);
		m_worker.reset();
		return DeviceStatus::Refused;
	}
	m_hasShift = false;
	m_lastNow = 0;
	using Phase = Worker::Phase;
	m_worker->waitFor(kOpeningPatience, [](Phase p) { return p != Phase::Connecting; });
	m_worker->waitFor(kOpeningPatience, [](Phase p) { return p == Phase::Running || p == Phase::Ended; });
	const DeviceStatus status = m_worker->status.load(std::memory_order_acquire);
	if (status == DeviceStatus::Ok && takeInfo()) return status;
	{
		const std::lock_guard<std::mutex> lock(m_worker->mutex);
		if (m_worker->complaint.empty()) m_worker->complaint = "the device was found but gave no sample in time";
	}
	m_worker->ending.store(true, std::memory_order_release);
	return DeviceStatus::Disconnected;
}

// The worker is kept after its end, because it holds the complaint.
void ThreadedDevice::close() noexcept
{
	if (!m_worker) return;
	m_worker->ending.store(true, std::memory_order_release);
	if (!m_worker->waitFor(kPatience, [](Worker::Phase p) { return p == Worker::Phase::Ended; }))
	{
		m_worker->status.store(DeviceStatus::NotOpen, std::memory_order_release);
		if (m_worker->thread.joinable()) m_worker->thread.detach();
		const std::lock_guard<std::mutex> lock(m_worker->mutex);
		m_worker->complaint = "a call into the driver has not come back; end the program to get rid of it";
		return;
	}
	if (m_worker->thread.joinable()) m_worker->thread.join();
	m_worker->status.store(DeviceStatus::NotOpen, std::memory_order_release);
	if (m_worker->link) m_link = std::move(m_worker->link);
}

DeviceStatus ThreadedDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	if (!m_worker) return DeviceStatus::NotOpen;
	const DeviceStatus status = m_worker->status.load(std::memory_order_acquire);
	if (status != DeviceStatus::Ok) return status;
	m_worker->samples.fetch();
	state = m_worker->samples.readable().state;
	// The offset from the link's clock to the caller's. The largest difference is the one with the smallest delay between the two readings.
	const std::int64_t shift = now - realNow();
	m_shift = m_hasShift ? std::max(m_shift, shift) : shift;
	m_hasShift = true;
	m_lastNow = now;
	state.sampledAt = std::min(now, state.sampledAt + m_shift);
	return status;
}

DeviceStatus ThreadedDevice::write(const DeviceCommand& command) noexcept
{
	if (!m_worker) return DeviceStatus::NotOpen;
	const DeviceStatus status = m_worker->status.load(std::memory_order_acquire);
	if (status != DeviceStatus::Ok) return status;
	if (!isFinite(command.wrench)) return DeviceStatus::Refused;
	const std::int64_t from = std::max(m_lastNow, command.computedAt);
	const std::int64_t life = command.expiresAt > from ? std::min(command.expiresAt - from, kLongestLife) : 0;
	m_worker->commands.write({command, realNow() + life});
	return status;
}

bool ThreadedDevice::readHand(HandState& hand) noexcept
{
	if (!m_worker || !(m_info.sensed & kHandJointsSensed)) return false;
	hand = m_worker->samples.readable().hand;
	return true;
}

std::string ThreadedDevice::complaint() const
{
	if (!m_worker) return {};
	const std::lock_guard<std::mutex> lock(m_worker->mutex);
	return m_worker->complaint;
}
}  // namespace devicebridge
