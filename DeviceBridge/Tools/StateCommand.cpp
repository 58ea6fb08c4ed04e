// SPDX-License-Identifier: Zlib
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Timing/Clock.h"
#include "DeviceBridge/Tools/Commands.h"

namespace devicebridge::tools
{
namespace
{
constexpr std::int64_t kTick = 1'000'000;  // [ns]
constexpr std::int64_t kTries = 2000;      // ticks between two tries to open a device

/// A device that is looked at, also while it is lost: drivers open it again by themselves.
struct Watched
{
	std::string uri, refusal, shown;
	std::unique_ptr<Device> device;
	DeviceState state;
	DeviceStatus status = DeviceStatus::NotOpen;
	std::uint64_t samples = 0;

	void open()
	{
		auto opened = DeviceRegistry().open(uri);
		if (opened) device = std::move(opened).value();
		else refusal = opened.error().message;
	}
	/// Reads once, without a force.
	void read(std::int64_t now)
	{
		if (!device) return;
		DeviceState next = state;
		status = device->read(now, next);
		if (status != DeviceStatus::Ok) return;
		if (next.sequence != state.sequence || next.sampledAt != state.sampledAt) ++samples;
		state = next;
	}
	/// What keeps forces from it; "ready" if nothing does.
	std::string words() const
	{
		if (!device) return refusal;
		if (status != DeviceStatus::Ok)
		{
			const std::string complaint = device->complaint();
			return "lost: " + (complaint.empty() ? std::string(describe(status)) : complaint);
		}
		if (!isRigid(state.X_WH)) return "lost: " + std::string(describe(DeviceStatus::InvalidState));
		const std::string missing = describeMissing(state.flags);
		if (missing.empty()) return "ready";
		return state.flags & kCalibrated ? missing : missing + ": " + howToCalibrate(uri);
	}
};

std::vector<Watched> openAll(const std::vector<std::string>& uris)
{
	std::vector<Watched> devices;
	for (const std::string& uri : uris)
	{
		devices.emplace_back().uri = uri;
		devices.back().open();
	}
	return devices;
}

Report rowOf(const Watched& w, double seconds)
{
	Report row{{"uri", w.uri}, {"state", w.words()}};
	if (!w.device) return row;
	const DeviceInfo& info = w.device->info();
	row["model"] = info.model;
	if (w.samples == 0) return row;
	row["x"] = w.state.X_WH.translation.x;
	row["y"] = w.state.X_WH.translation.y;
	row["z"] = w.state.X_WH.translation.z;
	std::string buttons;
	for (int i = 0; i < 32; ++i)
		if (w.state.buttons >> i & 1U) buttons += (buttons.empty() ? "" : " ") + std::to_string(i + 1);
	row["buttons"] = buttons.empty() ? "none" : buttons;
	row["samples_hz"] = std::round(static_cast<double>(w.samples) / seconds);
	return row;
}

/// Prints a line whenever the state of a device changes: unplugged, back, a hand on it.
void reportChanges(std::vector<Watched>& devices, double since)
{
	for (Watched& w : devices)
	{
		const std::string words = w.words();
		if (words == w.shown) continue;
		std::printf("%8.3f s  %s  %s\n", since, w.uri.c_str(), words.c_str());
		w.shown = words;
	}
	std::fflush(stdout);
}
}  // namespace

int runState(const StateArguments& arguments)
{
	std::vector<Watched> devices = openAll(arguments.uris);
	RealClock clock;
	const std::int64_t start = clock.now();
	const double seconds = arguments.seconds > 0 ? arguments.seconds : arguments.watch ? 3600 : 0.5;
	for (std::int64_t i = 0; i < static_cast<std::int64_t>(1000 * seconds); ++i)
	{
		clock.sleepUntil(start + i * kTick);
		for (Watched& w : devices)
		{
			// A device that was not there may be plugged in later.
			if (arguments.watch && !w.device && i % kTries == kTries - 1) w.open();
			w.read(clock.now());
		}
		// Words may allocate and wait, so they are asked for at 10 Hz.
		if (arguments.watch && i % 100 == 50) reportChanges(devices, 1e-9 * static_cast<double>(clock.now() - start));
	}
	Report report = newReport();
	Report& rows = report["devices"] = Report::list();
	bool all = true;
	for (const Watched& w : devices)
	{
		rows.append(rowOf(w, seconds));
		all = all && w.device && w.status == DeviceStatus::Ok && isRigid(w.state.X_WH);
	}
	if (!arguments.watch || arguments.json) print(report, arguments.json);
	for (Watched& w : devices)
		if (w.device) w.device->close();
	return all ? kGood : kBadInput;
}
}  // namespace devicebridge::tools
