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

/// CLOCK_MONOTONIC with absolute sleeps; std::chrono::steady_clock where the platform lacks it.
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
