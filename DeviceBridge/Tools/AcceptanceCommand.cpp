// SPDX-License-Identifier: Zlib
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <vector>

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Base/Version.h"
#include "DeviceBridge/Drivers/AssumedLimits.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Tools/AcceptancePerson.h"
#include "DeviceBridge/Tools/AcceptancePush.h"
#include "DeviceBridge/Tools/Commands.h"

using ist::Vec3;

namespace devicebridge::tools
{
namespace
{
constexpr double kWay = 0.04, kShortestWay = 0.01;           // of the simulated hand, and of any hand that counts as moved [m]
constexpr double kTurn = 0.7, kSmallestTurn = 0.2;           // [rad]
constexpr double kAligned = 0.8;                             // smallest cosine of a movement that goes along an axis
constexpr double kScaleTolerance = 0.05;                     // a ruler and a hand measure no better
constexpr double kSecondsOfRate = 3, kSecondsToUnplug = 30;  // [s]
constexpr int kAcceptanceVersion = 1;
constexpr double kMostAtEnd = 0.1;     // the safety chain may damp a handle that moves [N]
constexpr double kReleaseForce = 0.3;  // [N]

/// Directions as a person names them; the opposite of each stands beside it.
constexpr const char* kDirections[] = {"right", "left", "up", "down", "towards", "away"};

/// W's axes of right, up and towards the person, where the driver's page says them.
const std::map<std::string, std::array<Vec3, 3>>& documentedAxes()
{
	static const std::array<Vec3, 3> upIsY{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
	static const std::map<std::string, std::array<Vec3, 3>> axes = {{"sim", upIsY}, {"spnav", upIsY}, {"rumble", upIsY}, {"openxr", upIsY},
		{"hd", upIsY}, {"dhd", {Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 0, 0}}}};
	return axes;
}

Report listOf(const Vec3& v) { return Report::list({v.x, v.y, v.z}); }

/// The signed axis of W that is nearest, such as "-x".
std::string axisName(const Vec3& v)
{
	int largest = 0;
	for (int i = 1; i < 3; ++i)
		if (std::fabs(v[i]) > std::fabs(v[largest])) largest = i;
	return std::string(v[largest] < 0 ? "-" : "+") + "xyz"[largest];
}

/// A number of millimetres, above 0 and below 10 m, as a length [m]; empty for any other text.
std::optional<double> lengthIn(const std::string& text)
{
	char* end = nullptr;
	const double length = 1e-3 * std::strtod(text.c_str(), &end);
	if (text.empty() || *end != '\0' || !(length > 0 && length < 10)) return std::nullopt;
	return length;
}

/// Walks a person through the parts, and keeps what was found.
class Acceptance
{
public:
	Acceptance(Device& device, Clock& clock, const std::string& uri) : m_device(device), m_clock(clock), m_person(device, clock)
	{
		const auto known = documentedAxes().find(uri.substr(0, uri.find(':')));
		if (known != documentedAxes().end()) m_documented = &known->second, m_axes = known->second;
	}

	/// All parts, in their order. Returns an exit code; kGood also where a part failed.
	int run(bool withForces);
	Report parts() const { return m_parts; }
	bool ok() const { return m_ok; }
	bool complete() const { return m_complete; }
	const std::string& comment() const { return m_comment; }

private:
	void part(const char* name, void (Acceptance::*run)(Report&));
	/// An answer; empty after a skip, an error or the end of standard input, which the part leaves at once.
	std::string answer(const std::string& question);
	bool enter(const std::string& question) { return answer(question + "; press Enter"), going(); }
	bool going() const { return !m_skipped && !m_ended && m_error.empty() && !m_interrupted; }
	DeviceState sample();
	/// An error where neither the driver's page nor the part `axes` has said how the device's world lies.
	bool knowsAxes();

	void axes(Report& row);
	void turns(Report& row);
	void scale(Report& row);
	void rate(Report& row);
	void forces(Report& row);
	void release(Report& row);
	void unplug(Report& row);
	bool pushAlong(int axis, double sign, Report& pushes);
	std::string directionOf(const Vec3& v) const;

	Device& m_device;
	Clock& m_clock;
	AcceptancePerson m_person;
	const std::array<Vec3, 3>* m_documented = nullptr;
	std::array<Vec3, 3> m_axes{};  // of right, up and towards the person, in W; zero: unknown
	Report m_parts = Report::list();
	std::string m_error, m_comment;
	bool m_skipped = false, m_ended = false, m_interrupted = false, m_ok = true, m_complete = true;
};

std::string Acceptance::answer(const std::string& question)
{
	if (!going()) return {};
	std::optional<std::string> line = m_person.ask(question);
	m_ended = !line;
	if (line) std::transform(line->begin(), line->end(), line->begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
	m_skipped = line && *line == "skip";
	return going() ? *line : std::string();
}

DeviceState Acceptance::sample()
{
	if (!going()) return {};
	const ist::Result<DeviceState> state = m_person.sample();
	if (!state) m_error = state.error().message;
	return state ? state.value() : DeviceState();
}

bool Acceptance::knowsAxes()
{
	const bool known = std::all_of(m_axes.begin(), m_axes.end(), [](const Vec3& axis) { return norm(axis) > 0; });
	if (!known) m_error = "the axes are unknown: go through the part axes first";
	return known;
}

void Acceptance::part(const char* name, void (Acceptance::*run)(Report&))
{
	if (m_ended || m_interrupted) return;
	m_skipped = false;
	m_error.clear();
	m_person.tell(std::string("\n") + name);
	Report row{{"part", name}, {"ok", false}};
	(this->*run)(row);
	if (m_skipped) row = Report{{"part", name}, {"skipped", true}};
	if (!m_error.empty()) row["error"] = m_error;
	m_complete = m_complete && !m_skipped;
	m_ok = m_ok && (m_skipped || row["ok"].flag());
	m_person.tell(m_skipped ? "skipped" : row["ok"].flag() ? "ok" : m_error.empty() ? "NOT ok" : "NOT ok: " + m_error);
	m_parts.append(std::move(row));
}

void Acceptance::axes(Report& row)
{
	static const char* const kWays[] = {"to your right", "up", "towards you"};
	if (!enter("Hold the handle still in the middle of its workspace")) return;
	std::array<Vec3, 3> found{};
	Report& ways = row["movements"] = Report::list();
	bool clear = true;
	for (int i = 0; i < 3 && going(); ++i)
	{
		const Vec3 from = sample().X_WH.translation, by = kWay * Vec3{double(i == 0), double(i == 1), double(i == 2)};
		m_person.move(by);
		if (!enter(std::string("Move the handle some 5 cm ") + kWays[i] + " and hold it still")) return;
		const Vec3 way = sample().X_WH.translation - from;
		const double length = norm(way) / m_device.info().scale;
		ways.append(Report{{"asked", kDirections[2 * i]}, {"way", listOf(way)}, {"axis", axisName(way)}});
		found[size_t(i)] = normalized(way);
		const double along = std::max({std::fabs(found[size_t(i)].x), std::fabs(found[size_t(i)].y), std::fabs(found[size_t(i)].z)});
		clear = clear && length >= kShortestWay && along >= kAligned;
		m_person.move(-1.0 * by);
		if (!enter("Move it back and hold it still")) return;
	}
	if (!going()) return;
	const double handed = dot(cross(found[0], found[1]), found[2]);
	bool asDocumented = true;
	for (size_t i = 0; m_documented && i < 3; ++i) asDocumented = asDocumented && dot(found[i], (*m_documented)[i]) >= kAligned;
	row["right_handed"] = handed > kAligned;
	row["documented"] = m_documented != nullptr;
	row["as_documented"] = asDocumented;
	row["ok"] = clear && handed > kAligned && asDocumented;
	m_axes = found;
}

void Acceptance::turns(Report& row)
{
	static const char* const kWays[] = {
		"so that the end that points away from you goes up", "counter-clockwise, seen from above", "so that its right side goes up"};
	if (!(m_device.info().sensed & kRotation))
	{
		row["ok"] = true;
		row["sensed"] = false;
		return;
	}
	if (!knowsAxes() || !enter("Hold the handle still")) return;
	bool right = true;
	Report& ways = row["movements"] = Report::list();
	for (size_t i = 0; i < 3 && going(); ++i)
	{
		const ist::Mat3 from = sample().X_WH.rotation;
		const Vec3 by = kTurn * Vec3{double(i == 0), double(i == 1), double(i == 2)};
		m_person.move({}, by);
		if (!enter(std::string("Turn the handle by some 45 degrees ") + kWays[i] + ", and hold it still")) return;
		const Vec3 turn = rotationVector(ist::quaternion(sample().X_WH.rotation * transpose(from)));
		const double cosine = norm(turn) > kSmallestTurn ? dot(turn, m_axes[i]) / norm(turn) : 0;
		ways.append(Report{{"about", kDirections[2 * i]}, {"turn", listOf(turn)}, {"cosine", cosine}});
		right = right && cosine >= kAligned;
		m_person.move({}, -1.0 * by);
		if (!enter("Turn it back and hold it still")) return;
	}
	row["ok"] = right && going();
}

void Acceptance::scale(Report& row)
{
	if (!enter("Lay a ruler beside the handle and hold the handle still at its beginning")) return;
	const Vec3 from = sample().X_WH.translation;
	m_person.move({kWay, 0, 0});
	std::optional<double> typed = lengthIn(answer("Move the handle along the ruler, hold it still, and type by how many millimetres"));
	while (going() && !typed) typed = lengthIn(answer("A number of millimetres alone, such as 42.5"));
	const double wanted = typed.value_or(0), way = distance(sample().X_WH.translation, from);
	m_person.move({-kWay, 0, 0});
	if (!going()) return;
	row["ruler_m"] = wanted;
	row["device_m"] = way;
	row["scale"] = m_device.info().scale;
	row["ok"] = std::fabs(way / (m_device.info().scale * wanted) - 1) <= kScaleTolerance;
}

void Acceptance::rate(Report& row)
{
	if (!enter("Move the handle slowly to and fro for three seconds, beginning when you press Enter")) return;
	m_person.move({kWay, 0, 0}, {}, 2 * kSecondsOfRate);
	std::vector<std::int64_t> fresh, costs;
	DeviceState last;
	RealClock real;
	const std::int64_t begin = m_clock.now();
	for (std::int64_t i = 0; i < std::int64_t(1000 * kSecondsOfRate); ++i)
	{
		m_clock.sleepUntil(begin + i * 1'000'000);
		DeviceState state;
		const std::int64_t before = real.now();
		const DeviceStatus status = m_device.read(m_clock.now(), state);
		costs.push_back(real.now() - before);
		if (status != DeviceStatus::Ok) m_error = describe(status);
		if (!going()) return;
		const bool repeats = state.sequence == last.sequence && state.X_WH.translation == last.X_WH.translation;
		if (!repeats) fresh.push_back(m_clock.now());
		last = state;
	}
	m_person.move({-kWay, 0, 0});
	std::int64_t longest = 0;
	for (size_t i = 1; i < fresh.size(); ++i) longest = std::max(longest, fresh[i] - fresh[i - 1]);
	std::sort(costs.begin(), costs.end());
	const double seconds = 1e-9 * static_cast<double>(m_clock.now() - begin), rate = static_cast<double>(fresh.size()) / seconds;
	row["rate_hz"] = rate;
	row["longest_gap_s"] = 1e-9 * static_cast<double>(longest);
	row["read_median_us"] = 1e-3 * static_cast<double>(costs[costs.size() / 2]);
	row["read_longest_us"] = 1e-3 * static_cast<double>(costs.back());
	row["velocity_estimated"] = last.velocityEstimated;
	// Nine tenths of what the device states, or of the rate of the loop.
	row["ok"] = rate >= 0.9 * std::min(1000.0, m_device.info().nominalRate);
}

std::string Acceptance::directionOf(const Vec3& v) const
{
	std::string nearest;
	double most = 0;
	for (size_t i = 0; i < 3; ++i)
	{
		const double along = dot(v, m_axes[i]);
		if (std::fabs(along) > most) most = std::fabs(along), nearest = kDirections[2 * i + (along < 0)];
	}
	return nearest;
}

bool Acceptance::pushAlong(int axis, double sign, Report& pushes)
{
	const double force = trialForce(m_device.info());
	const Vec3 direction = sign * Vec3{double(axis == 0), double(axis == 1), double(axis == 2)};
	const std::string name = axisName(direction), expected = directionOf(direction);
	if (!enter("Hold the handle loosely in the middle. It will push for three seconds")) return false;
	const PushOutcome pushed = push(m_device, m_clock, direction, force);
	m_interrupted = pushed.interrupted;
	std::string felt = answer("Which way did it push (right, left, up, down, towards, away, nothing)");
	while (going() && felt != "nothing" && std::find(std::begin(kDirections), std::end(kDirections), felt) == std::end(kDirections))
		felt = answer("One of right, left, up, down, towards, away, nothing");
	if (!going()) return false;
	const bool ok = !expected.empty() && felt == expected && pushed.moved >= 0 && pushed.cause == FaultCause::None &&
		pushed.atEnd <= kMostAtEnd && pushed.strongest > 0.5 * force;
	pushes.append(Report{{"axis", name}, {"expected", expected}, {"felt", felt}, {"strongest_n", pushed.strongest},
		{"moved_m", pushed.moved}, {"fastest_m_s", pushed.fastest}, {"guarded", pushed.guarded}, {"fault", describe(pushed.cause)},
		{"at_end_n", pushed.atEnd}, {"ok", ok}});
	return ok;
}

void Acceptance::forces(Report& row)
{
	if (!knowsAxes()) return;
	const DeviceState state = sample();
	if (!going()) return;
	if ((state.flags & (kCalibrated | kForcesEnabled)) != (kCalibrated | kForcesEnabled))
		m_error = state.flags & kCalibrated ? "the device says that its forces are switched off: switch them on and begin again"
											: "the device says that it is not calibrated: calibrate it and begin again";
	if (!going()) return;
	row["force_n"] = trialForce(m_device.info());
	Report& pushes = row["pushes"] = Report::list();
	bool ok = true;
	for (int axis = 0; axis < 3; ++axis)
		for (const double sign : {1.0, -1.0})
			if (going() && (m_device.info().actuated >> axis & 1U)) ok = pushAlong(axis, sign, pushes) && ok;
	row["ok"] = ok && going() && pushes.size() > 0;
}

void Acceptance::release(Report& row)
{
	const double force = std::min(kReleaseForce, trialForce(m_device.info()));
	const Vec3 up = norm(m_axes[1]) > 0 ? m_axes[1] : Vec3{0, 1, 0};
	if (!enter("Hold the handle in the middle. It will push upwards a little; let go of it when you feel that")) return;
	m_person.move(0.1 * up, {}, 0.2, 1.2);  // a handle that is let go is pushed away
	const PushOutcome pushed = push(m_device, m_clock, up, force);
	m_interrupted = pushed.interrupted;
	const std::string rests = answer("Did it come to rest by itself (yes, no)");
	m_person.move(-0.1 * up);
	if (!going()) return;
	row["guarded"] = pushed.guarded;
	row["after_guard_n"] = pushed.afterGuard;
	row["dead_man_switch"] = pushed.handGone;
	row["fastest_m_s"] = pushed.fastest;
	row["came_to_rest"] = rests == "yes" || rests == "y";
	row["at_end_n"] = pushed.atEnd;
	row["ok"] = row["came_to_rest"].flag() && pushed.afterGuard <= kMostAtEnd && pushed.atEnd <= kMostAtEnd;
}

void Acceptance::unplug(Report& row)
{
	if (!enter("Have cable or power switch at hand. Unplug the device within half a minute after you press Enter")) return;
	m_person.unplug();
	const LossOutcome loss = waitForLoss(m_device, m_clock, kSecondsToUnplug);
	m_interrupted = loss.interrupted;
	row["cause"] = describe(loss.cause);
	row["complaint"] = m_device.complaint();
	if (!enter("Plug it in again and wait until it is ready")) return;
	m_person.plugIn();
	m_device.close();
	m_device.open();
	sample();
	row["back"] = m_error.empty();
	row["ok"] = loss.cause != FaultCause::None && m_error.empty();
}

int Acceptance::run(bool withForces)
{
	m_person.tell(withForces ? "The device will push with at most 1 N, rising slowly. Keep face and loose things away from it."
							 : "No force is sent.");
	if (m_person.isSimulated())
		m_person.tell("A simulated hand makes the movements. What a person would measure and feel: 40 (mm), and right, left, up, down, "
					  "towards, away in this order; it comes to rest: yes.");
	m_person.tell("Answer `skip` to leave a part out. The file is written at the end.");
	if (const auto begin = m_person.ask("Type yes to begin"); !begin || *begin != "yes")
		return fail("nothing was done: the answer was not yes");
	part("axes", &Acceptance::axes);
	part("turns", &Acceptance::turns);
	part("scale", &Acceptance::scale);
	part("rate", &Acceptance::rate);
	if (withForces) part("forces", &Acceptance::forces);
	if (withForces) part("release", &Acceptance::release);
	part("unplug", &Acceptance::unplug);
	m_complete = m_complete && withForces;
	m_device.close();
	if (m_interrupted) return fail("interrupted: the device is at zero, and no file was written", kInterrupted);
	if (!m_ended) m_comment = m_person.ask("Anything else to say, in one line").value_or("");
	return m_ended ? fail("standard input ended before the last answer: no file was written") : kGood;
}

/// What the device says of itself.
Report describe(const DeviceInfo& info, const std::string& uri)
{
	Report device{{"uri", uri}, {"maker", info.maker}, {"model", info.model}, {"serial", info.serial}, {"peak_force", info.peakForce},
		{"continuous_force", info.continuousForce}, {"max_stiffness", info.maxStiffness}, {"nominal_rate", info.nominalRate},
		{"scale", info.scale}};
	device["assumed"] = namesOfAssumed(info.assumed);
	return device;
}
}  // namespace

int runAcceptance(const RunArguments& arguments)
{
	if (const auto obstacle = ist::whyNotWritable(arguments.output)) return fail(obstacle->message);
	auto opened = DeviceRegistry().open(arguments.uri);
	if (!opened) return fail(opened.error().message);
	Device& device = *opened.value();
	if (!arguments.withoutForces && !(trialForce(device.info()) > 0))
		return fail(arguments.uri + " exerts no force, or none whose limit is known: --without-forces walks through the rest");
	VirtualClock virtualClock;
	RealClock realClock;
	const bool simulated = AcceptancePerson(device, realClock).isSimulated();
	Clock& clock = simulated && !arguments.realTime ? static_cast<Clock&>(virtualClock) : realClock;
	Acceptance acceptance(device, clock, arguments.uri);
	if (const int code = acceptance.run(!arguments.withoutForces); code != kGood) return code;

	Report report = newReport();
	report["acceptance"] = kAcceptanceVersion;
	report["program"] = "devicebridge " BULLETHAPTICS_VERSION;
	report["device"] = describe(device.info(), arguments.uri);
	report["simulated"] = simulated;
	report["parts"] = acceptance.parts();
	report["complete"] = acceptance.complete();
	report["ok"] = acceptance.ok();
	report["comment"] = acceptance.comment();
	const std::string text = report.dump(true) + "\n";
	const auto written = ist::writeFileAtomically(arguments.output, reinterpret_cast<const std::byte*>(text.data()), text.size());
	if (!written) return fail(written.error().message);
	Report shown = newReport();
	shown["file"] = arguments.output;
	shown["complete"] = acceptance.complete();
	shown["ok"] = acceptance.ok();
	print(shown, arguments.json);
	return acceptance.ok() ? kGood : kBadInput;
}
}  // namespace devicebridge::tools
