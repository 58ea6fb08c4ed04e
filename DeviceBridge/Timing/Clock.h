// SPDX-License-Identifier: Zlib
#pragma once

#include <atomic>
#include <cstdint>

namespace devicebridge
{
/// Source of time for a stepping thread, in nanoseconds from an arbitrary origin.
class Clock
{
public:
	virtual ~Clock() = default;
	virtual std::int64_t now() const noexcept = 0;
	/// Sleeps until `deadline` [ns]; returns at once if it has passed.
	virtual void sleepUntil(std::int64_t deadline) noexcept = 0;
};

/// The monotonic clock of the system, with absolute sleeps. Windows: the performance counter, with high-resolution timers.
class RealClock final : public Clock
{
public:
	std::int64_t now() const noexcept override;
	void sleepUntil(std::int64_t deadline) noexcept override;
};

/// A clock whose time passes only during sleepUntil().
class VirtualClock final : public Clock
{
public:
	std::int64_t now() const noexcept override;
	void sleepUntil(std::int64_t deadline) noexcept override;

private:
	std::atomic<std::int64_t> m_now{0};
};
}  // namespace devicebridge
