// SPDX-License-Identifier: Zlib
#include "demos/scenes/Pages/SafetyPage.h"

#include "BulletISTCollision/Json/JsonValue.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Safety/SafetyLimiter.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace devicebridge;
using ist::Vec3;

namespace scenes
{
namespace
{
constexpr std::int64_t kMs = 1'000'000;  // [ns]
constexpr double kPeak = 10, kContinuous = 2;

DeviceInfo device()
{
	DeviceInfo info;
	info.actuated = kTranslation | kRotation;
	info.peakForce = kPeak, info.continuousForce = kContinuous;
	info.peakTorque = 0.2, info.continuousTorque = 0.05;
	info.maxDamping = 20, info.maxAngularDamping = 0.05;
	return info;
}

/// Settings with every optional stage off. Each row switches its own stage on.
SafetySettings bare()
{
	SafetySettings s;
	s.fullUntil = 3'600'000 * kMs, s.zeroFrom = 2 * s.fullUntil;
	s.rampTime = 0;
	s.startInsideLatch = s.passivity = false;
	s.riseTime = 1;
	s.heatTime = 1e12;
	s.maxSpeed = s.maxAngularSpeed = std::numeric_limits<double>::infinity();
	return s;
}

DeviceCommand command(const Vec3& force, std::int64_t computedAt, const Vec3& torque = {})
{
	DeviceCommand c;
	c.computedAt = computedAt;
	c.expiresAt = std::numeric_limits<std::int64_t>::max();
	c.wrench = {force, torque};
	return c;
}

/// Commands that a limiter sends, tick by tick, for a constant requested wrench.
class Attack
{
public:
	explicit Attack(const SafetySettings& settings, const DeviceInfo& info = device()) : m_limiter(info, settings) {}

	HandSample hand;
	ist::Wrench tick(const Vec3& force, const Vec3& torque = {})
	{
		m_now += kMs;
		return m_limiter.limit(command(force, m_now, torque), hand, m_now).wrench;
	}
	/// Output for the command of the first tick when it has reached this age.
	ist::Wrench late(const Vec3& force, std::int64_t age)
	{
		tick(force);
		for (std::int64_t t = kMs; t <= age; t += kMs) m_last = m_limiter.limit(command(force, m_now), hand, m_now + t).wrench;
		return m_last;
	}

private:
	SafetyLimiter m_limiter;
	std::int64_t m_now = 0;
	ist::Wrench m_last;
};

template <class Change> SafetySettings only(Change&& change)
{
	SafetySettings s = bare();
	change(s);
	return s;
}

double sizeOf(double force) { return std::isfinite(force) ? std::fabs(force) : std::numeric_limits<double>::infinity(); }

/// Largest change from one tick to the next after a step of the request from 0 to 10 N.
double steepest(const SafetySettings& settings)
{
	Attack attack(settings);
	double last = attack.tick({}).force.x, most = 0;
	for (int i = 0; i < 200; ++i)
	{
		const double now = attack.tick({kPeak, 0, 0}).force.x;
		most = std::max(most, now - last);
		last = now;
	}
	return most;
}

/// Amplitude of the oscillation in the third second divided by that in the first. A free handle is on a wall that is stiffer than its
/// delay allows.
double growth(const SafetySettings& settings)
{
	SimulatedProfile profile = simulatedProfile("sigma7").value();
	profile.handStiffness = profile.handDamping = 0;
	profile.delayTicks = 3;
	profile.info.resolution = 0;
	const double beyond = 1.1 * profile.damping / 3.5e-3;
	SimulatedDevice handle(profile);
	handle.place({{}, {1e-3, 0, 0}});
	handle.open();
	SafetyLimiter limiter(profile.info, settings);
	DeviceState state;
	double most[3] = {};
	for (int i = 0; i < 3000; ++i)
	{
		handle.read(i * kMs, state);
		const double x = state.X_WH.translation.x;
		most[i / 1000] = std::max(most[i / 1000], std::fabs(x));
		HandSample hand;
		hand.X_WH = state.X_WH, hand.twist = state.twist;
		DeviceCommand c = limiter.limit(command({-beyond * x, 0, 0}, i * kMs), hand, i * kMs);
		c.expiresAt = (i + 20) * kMs;
		handle.write(c);
	}
	return most[2] / most[0];
}

double rmsOverAMinute(const SafetySettings& settings)
{
	Attack attack(settings);
	double sum = 0;
	for (int i = 0; i < 60000; ++i) sum += squaredNorm(attack.tick({kPeak, 0, 0}).force) / 60000;
	return std::sqrt(sum);
}

/// Power into a hand that already moves at 2 m/s [W].
double powerAtSpeed(const SafetySettings& settings)
{
	Attack attack(settings);
	attack.hand.twist.linear = {2, 0, 0};
	attack.tick({kPeak, 0, 0});
	return 2 * attack.tick({kPeak, 0, 0}).force.x;
}

void addInnerOverlapChoices(std::vector<SafetyRow>& rows)
{
	const Vec3 push{kPeak, 0, 0};
	const double nan = std::numeric_limits<double>::quiet_NaN();
	rows.push_back(
		{"finite", "a law that divides by zero", "force sent", "N", sizeOf(nan), sizeOf(Attack(bare()).tick({nan, 0, 0}).force.x), 0});
	const SafetySettings expiry = only(
		[](SafetySettings& s) { s.fullUntil = SafetySettings().fullUntil, s.zeroFrom = SafetySettings().zeroFrom; });
	rows.push_back({"age", "a law that has not answered for 20 ms", "force sent", "N", Attack(bare()).late(push, 20 * kMs).force.x,
		Attack(expiry).late(push, 20 * kMs).force.x, 0});
	Attack gone(bare());
	gone.hand.flags &= ~static_cast<unsigned>(kHandPresent);
	rows.push_back(
		{"enabled", "a handle that nobody holds", "force sent", "N", Attack(bare()).tick(push).force.x, gone.tick(push).force.x, 0});
	rows.push_back({"ramp", "10 N in the tick of enabling", "most change in a tick", "N", steepest(bare()),
		steepest(only([](SafetySettings& s) { s.rampTime = SafetySettings().rampTime; })), 0.5});
	Attack inside(only([](SafetySettings&s) { s.startInsideLatch = true; })), insideBare(bare());
	inside.hand.inContact = insideBare.hand.inContact = true;
	rows.push_back({"start inside", "a tool inside a body when enabled", "force sent", "N", insideBare.tick(push).force.x,
		inside.tick(push).force.x, 0});
	DeviceInfo arrows = device();
	arrows.actuated = kTranslation;
	rows.push_back({"actuated", "a torque for a device without motors for it", "torque sent", "N m",
		Attack(bare()).tick({}, {0.1, 0, 0}).torque.x, Attack(bare(), arrows).tick({}, {0.1, 0, 0}).torque.x, 0});
}

void addLimits(std::vector<SafetyRow>& rows)
{
	rows.push_back({"passivity", "a wall 10 % stiffer than a delay of 3 ms allows", "growth of the swing in two seconds", "",
		growth(bare()), growth(only([](SafetySettings& s) { s.passivity = true; })), 1});
	rows.push_back({"slew", "10 N from one tick to the next", "most change in a tick", "N", steepest(bare()),
		steepest(only([](SafetySettings& s) { s.riseTime = SafetySettings().riseTime; })), 0.5 + 1e-9});
	DeviceInfo boundless = device();
	boundless.peakForce = 1e6;
	rows.push_back({"saturation", "100 N for a device of 10 N", "force sent", "N", norm(Attack(bare(), boundless).tick({60, 80, 0}).force),
		norm(Attack(bare()).tick({60, 80, 0}).force), kPeak + 1e-9});
	rows.push_back(
		{"continuous budget", "10 N for a minute, 2 N being the limit in the long run", "rms of the force", "N", rmsOverAMinute(bare()),
			rmsOverAMinute(only([](SafetySettings& s) { s.heatTime = SafetySettings().heatTime; })), 1.1 * kContinuous});
	rows.push_back({"over-speed", "a force along a hand that moves at 2 m/s", "power into the hand", "W", powerAtSpeed(bare()),
		powerAtSpeed(only([](SafetySettings& s) { s.maxSpeed = SafetySettings().maxSpeed; })), 0});
}
}  // namespace

bool SafetyOutcome::ok() const
{
	return !rows.empty() && std::all_of(rows.begin(), rows.end(), [](const SafetyRow& row) { return row.ok(); });
}

SafetyOutcome runSafety()
{
	SafetyOutcome out;
	addInnerOverlapChoices(out.rows);
	addLimits(out.rows);
	return out;
}

std::vector<std::vector<std::string>> summaryRows(const SafetyOutcome& o)
{
	std::vector<std::vector<std::string>> rows = {{"Result", o.ok() ? "ok" : "FAILED", ""}};
	for (const SafetyRow& r : o.rows)
		rows.push_back({r.stage + ": without -> with", formatNumber(r.without, 3) + " -> " + formatNumber(r.with, 3), r.unit});
	return rows;
}

HtmlReport makeReport(const SafetyOutcome& o)
{
	HtmlReport report("What keeps a hand safe");
	report.paragraph("The stages between a force law and a device, in their order, each attacked with what it is there for: what reaches a "
					 "device of 10 N "
					 "(2 N in the long run) without the stage, and with it alone. All of them are on by default.");
	std::vector<std::vector<std::string>> rows;
	for (const SafetyRow& r : o.rows)
		rows.push_back(
			{r.stage, r.attack, r.quantity, formatNumber(r.without, 3), formatNumber(r.with, 3), formatNumber(r.atMost, 3), r.unit});
	report.table({"Stage", "Attack", "Quantity", "Without", "With", "Safe up to", "Unit"}, rows);
	return report;
}

std::string makeJson(const SafetyOutcome& o)
{
	ist::JsonValue json = {{"schema", 1}, {"demo", "safety"}, {"ok", o.ok()}, {"stages", ist::JsonValue::list()}};
	for (const SafetyRow& r : o.rows)
		json["stages"].append({{"stage", r.stage}, {"attack", r.attack}, {"quantity", r.quantity}, {"unit", r.unit}, {"without", r.without},
			{"with", r.with}, {"at_most", r.atMost}});
	return json.dump();
}
}  // namespace scenes
