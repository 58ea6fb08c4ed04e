// SPDX-License-Identifier: Zlib
#include "demos/scenes/Scene/PaperFigures.h"

#include "BulletISTCollision/Core/Base/ThreadTime.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Json/JsonValue.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Platform/RealTimePriority.h"
#include "DeviceBridge/Timing/Clock.h"
#include "demos/scenes/Bodies/BodiesOnPlane.h"
#include "demos/scenes/Scene/SceneReport.h"

#include <algorithm>
#include <thread>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kStretch = 0.1;  // interval over which a rate is counted [s]
constexpr double kTickMicroseconds = 1000;

PaperScene::Spread spreadOf(const std::vector<double>& values)
{
	PaperScene::Spread spread;
	if (values.empty()) return spread;
	for (const double v : values) spread.mean += v / static_cast<double>(values.size());
	spread.p50 = quantile(values, 0.5);
	spread.p999 = quantile(values, 0.999);
	spread.max = quantile(values, 1);
	return spread;
}

/// Mean processor time of a thread that wakes once a millisecond and does nothing, scheduled like that of the hand [us].
double wakingMicroseconds()
{
	constexpr int kTicks = 1000;
	double used = 0;
	std::thread idle([&] {
		devicebridge::askForRealTimePriority(devicebridge::SteppingSettings().priority);
		devicebridge::RealClock clock;
		const std::int64_t begin = clock.now();
		const double before = ist::threadMicroseconds();
		for (int i = 1; i <= kTicks; ++i) clock.sleepUntil(begin + i * devicebridge::SteppingSettings().period);
		used = (ist::threadMicroseconds() - before) / kTicks;
	});
	idle.join();
	return used;
}

bool isNewAnswer(const std::vector<SceneTick>& ticks, size_t i) { return i > 0 && ticks[i].answer.number != ticks[i - 1].answer.number; }

/// Repeats the query alone, without law, model, thread or world.
std::vector<double> askAgain(SceneWorld& world, const PaperScene& scene)
{
	const SceneWorld::Body& tool = world.body(scene.run.scene.hands.front().tool);
	QueryWorkspace workspace;
	const auto ask = [&](const SceneTick& tick) {
		for (size_t i = 0; i < world.size(); ++i)
		{
			const SceneWorld::Body& body = world.body(i);
			if (i == scene.run.scene.hands.front().tool || !body.tree) continue;
			queryOverlap(*tool.tree, *body.tree, inverse(tick.tool) * poseOf(*body.body), workspace);
		}
	};
	const std::vector<SceneTick>& ticks = scene.hand().ticks;
	for (size_t i = 0; i < ticks.size(); i += 50) ask(ticks[i]);
	std::vector<double> times(ticks.size(), -1);
	for (size_t i = 0; i < ticks.size(); ++i)
	{
		if (!isNewAnswer(ticks, i)) continue;
		const double begin = ist::threadMicroseconds();
		ask(ticks[i]);
		times[i] = ist::threadMicroseconds() - begin;
	}
	return times;
}

/// Events per second in each interval; `count(i)` is the number of events of tick i.
template <class Count> ChartSeries rateOf(const std::string& name, const std::vector<SceneTick>& ticks, const Count& count)
{
	ChartSeries series{name, {}, {}, {}, false};
	double begin = ticks.front().time, events = 0;
	for (size_t i = 1; i < ticks.size(); ++i)
	{
		events += count(i);
		const double length = ticks[i].time - begin;
		if (length < kStretch) continue;
		series.x.push_back(begin + 0.5 * length);
		series.y.push_back(events / length);
		begin = ticks[i].time;
		events = 0;
	}
	return series;
}

ChartSeries forceRate(const PaperScene& s)
{
	return rateOf("force thread", s.hand().ticks, [](size_t) { return 1.0; });
}
ChartSeries contactRate(const PaperScene& s)
{
	const std::vector<SceneTick>& ticks = s.hand().ticks;
	return rateOf(
		"contact thread", ticks, [&](size_t i) { return static_cast<double>(ticks[i].answer.number - ticks[i - 1].answer.number); });
}

double leastOf(const ChartSeries& series) { return series.y.empty() ? 0 : *std::min_element(series.y.begin(), series.y.end()); }

void summarise(PaperScene& scene)
{
	const std::vector<SceneTick>& ticks = scene.hand().ticks;
	std::vector<double> periods, used, inDevice, answers, asked, bare, pairs;
	for (size_t i = 1; i < ticks.size(); ++i)
	{
		periods.push_back(ticks[i].period);
		used.push_back(ticks[i].threadMicroseconds);
		inDevice.push_back(ticks[i].deviceMicroseconds);
		if (ticks[i].contacts > 0) pairs.push_back(static_cast<double>(ticks[i].answer.pairs));
		if (!isNewAnswer(ticks, i)) continue;
		answers.push_back(ticks[i].answer.threadMicroseconds);
		asked.push_back(ticks[i].answer.queryMicroseconds);
		bare.push_back(scene.bareQuery[i]);
	}
	scene.period = spreadOf(periods);
	scene.tick = spreadOf(used);
	scene.answer = spreadOf(answers);
	scene.device = spreadOf(inDevice);
	scene.asked = spreadOf(asked);
	scene.query = spreadOf(bare);
	scene.touchingPairs = spreadOf(pairs);
	const double seconds = ticks.back().time - ticks.front().time;
	scene.forceRate = static_cast<double>(ticks.size() - 1) / seconds;
	scene.contactRate = static_cast<double>(ticks.back().answer.number - ticks.front().answer.number) / seconds;
	scene.slowestForceRate = leastOf(forceRate(scene));
	scene.slowestContactRate = leastOf(contactRate(scene));
	const double both = scene.tick.mean - scene.device.mean + scene.answer.mean;
	scene.overhead = (both - scene.asked.mean) / kTickMicroseconds;
	scene.waking = 2 * wakingMicroseconds() / kTickMicroseconds;
	scene.overheadWarm = (both - scene.query.mean) / kTickMicroseconds;
}

ChartSeries histogram(const PaperScene& scene)
{
	constexpr double kBin = 0.02, kEnd = 2;  // [ms]
	std::vector<double> bins(static_cast<size_t>(kEnd / kBin) + 1);
	const std::vector<SceneTick>& ticks = scene.hand().ticks;
	for (size_t i = 1; i < ticks.size(); ++i) bins[std::min(bins.size() - 1, static_cast<size_t>(1e3 * ticks[i].period / kBin))] += 1;
	ChartSeries series{scene.run.scene.name, {}, {}, {}, false};
	for (size_t b = 0; b < bins.size(); ++b)
		for (const double edge : {0.0, kBin})
		{
			series.x.push_back(kBin * static_cast<double>(b) + edge);
			series.y.push_back(100 * bins[b] / static_cast<double>(ticks.size() - 1));
		}
	return series;
}

/// Trace of the ticks with a new answer.
Trace answersOf(const PaperScene& scene, const std::function<double(size_t)>& value)
{
	auto places = std::make_shared<std::vector<size_t>>();
	for (size_t i = 1; i < scene.hand().ticks.size(); ++i)
		if (isNewAnswer(scene.hand().ticks, i)) places->push_back(i);
	const std::vector<SceneTick>& ticks = scene.hand().ticks;
	return {places->size(), [places, &ticks](size_t i) { return ticks[(*places)[i]].time; },
		[places, value](size_t i) { return value((*places)[i]); }};
}

std::string number(double value, int digits = 3) { return formatNumber(value, digits); }

void addScene(HtmlReport& report, const PaperScene& s)
{
	const std::vector<SceneTick>& ticks = s.hand().ticks;
	report.heading(s.run.scene.name);
	report.paragraph(s.run.scene.about);
	report.chart({"Rate of the force thread and of the contact thread", "time [s]", "rate [Hz]", {forceRate(s), contactRate(s)}});
	report.chart({"Intersecting pairs", "time [s]", "pairs",
		{envelope("pairs", traceOf(s.hand(), [](const SceneTick& t) { return static_cast<double>(t.answer.pairs); }))}});
	report.chart({"Processor time", "time [s]", "time [\xC2\xB5s]",
		{runningMean("force thread, a tick", traceOf(s.hand(), [](const SceneTick& t) { return t.threadMicroseconds; })),
			runningMean("contact thread, an answer", answersOf(s, [&ticks](size_t i) { return ticks[i].answer.threadMicroseconds; })),
			runningMean("the query alone", answersOf(s, [&s](size_t i) { return s.bareQuery[i]; }))}});
	report.chart({"Force on the hand", "time [s]", "force [N]",
		{envelope("size", traceOf(s.hand(), [](const SceneTick& t) { return norm(t.wrench.force); }))}});
}
}  // namespace

Result<std::vector<PaperScene>> runPaperFigures(const std::vector<std::string>& files, const SceneRunOptions& options)
{
	std::vector<PaperScene> scenes;
	for (const std::string& file : files)
	{
		const Result<Scene> scene = loadScene(file);
		if (!scene) return scene.error();
		if (scene.value().topology != SceneTopology::ContactThread) return Error{file + ": topology: these figures want contact-thread"};
		if (scene.value().hands.size() != 1) return Error{file + ": hand: these figures want one hand"};
		for (size_t i = 0; i < scene.value().bodies.size(); ++i)
			if (!scene.value().isTool(i) && !scene.value().bodies[i].fixed)
				return Error{scene.value().bodies[i].place + ": these figures want all bodies but the tool fixed"};
		std::unique_ptr<SceneWorld> world;
		Result<SceneOutcome> run = runScene(scene.value(), options, &world);
		if (!run) return run.error();
		if (run.value().interrupted) return Error{"the run was stopped", true};
		if (run.value().hands.front().ticks.size() < 2) return Error{file + ": the run ended before its second tick"};
		PaperScene& added = scenes.emplace_back();
		added.run = std::move(run).value();
		added.bareQuery = askAgain(*world, added);
		summarise(added);
	}
	return scenes;
}

std::vector<std::vector<std::string>> paperRows(const std::vector<PaperScene>& scenes)
{
	std::vector<std::vector<std::string>> rows;
	const auto row = [&](const char* name, const char* unit, auto value) {
		std::vector<std::string> cells = {name};
		for (const PaperScene& s : scenes) cells.push_back(value(s));
		cells.push_back(unit);
		rows.push_back(std::move(cells));
	};
	row("Ticks", "", [](const PaperScene& s) { return std::to_string(s.hand().ticks.size()); });
	row("Intersecting pairs in contact, median", "", [](const PaperScene& s) { return number(s.touchingPairs.p50, 6); });
	row("Intersecting pairs in contact, most", "", [](const PaperScene& s) { return number(s.touchingPairs.max, 6); });
	row("Rate of the force thread, mean", "Hz", [](const PaperScene& s) { return number(s.forceRate, 4); });
	row("Rate of the force thread, slowest 0.1 s", "Hz", [](const PaperScene& s) { return number(s.slowestForceRate, 4); });
	row("Rate of the contact thread, mean", "Hz", [](const PaperScene& s) { return number(s.contactRate, 4); });
	row("Rate of the contact thread, slowest 0.1 s", "Hz", [](const PaperScene& s) { return number(s.slowestContactRate, 4); });
	row("Period, median", "ms", [](const PaperScene& s) { return number(1e3 * s.period.p50); });
	row("Period, 99.9th percentile", "ms", [](const PaperScene& s) { return number(1e3 * s.period.p999); });
	row("Period, longest", "ms", [](const PaperScene& s) { return number(1e3 * s.period.max); });
	row("Processor time of a tick of the force thread, median", "us", [](const PaperScene& s) { return number(s.tick.p50); });
	row("Processor time of a tick of the force thread, 99.9th percentile", "us", [](const PaperScene& s) { return number(s.tick.p999); });
	row("of this the simulated hand, median", "us", [](const PaperScene& s) { return number(s.device.p50); });
	row("Processor time of an answer of the contact thread, median", "us", [](const PaperScene& s) { return number(s.answer.p50); });
	row("Processor time of an answer of the contact thread, 99.9th percentile", "us",
		[](const PaperScene& s) { return number(s.answer.p999); });
	row("of this the query, median", "us", [](const PaperScene& s) { return number(s.asked.p50); });
	row("The query asked again in one go, median", "us", [](const PaperScene& s) { return number(s.query.p50); });
	row("The query asked again in one go, 99.9th percentile", "us", [](const PaperScene& s) { return number(s.query.p999); });
	row("Both threads over query and simulated hand, mean share of a tick", "%",
		[](const PaperScene& s) { return number(100 * s.overhead); });
	row("of this, waking two threads that do nothing", "%", [](const PaperScene& s) { return number(100 * s.waking); });
	row("The same over the query asked again in one go", "%", [](const PaperScene& s) { return number(100 * s.overheadWarm); });
	row("Largest force on the hand", "N", [](const PaperScene& s) { return number(s.hand().maxForce); });
	return rows;
}

HtmlReport paperPage(const std::vector<PaperScene>& scenes)
{
	HtmlReport report("Rates of force and contact");
	report.paragraph(
		"A simulated hand on a simulated sigma.7, in real time. The force thread ticks at 1 kHz, the contact thread asks the trees "
		"whenever a "
		"question is there, and the world steps in a third thread; nobody waits for anybody. The counterpart are figures 7 to 9 of the "
		"paper on UnrealHaptics, which reports 850 to 1,000 Hz for both threads.");
	report.paragraph(
		"Processor time is that of the thread itself (CLOCK_THREAD_CPUTIME_ID), so that what else the machine does does not count; periods "
		"are of the clock on the wall, and it does. What our threads cost over the bare query is theirs without the query, timed where it "
		"was asked, and without the "
		"simulated hand, which stands for a device. How much of it is the system's, which wakes two threads in each tick, shows a thread "
		"that does "
		"nothing else. The query was also asked again afterwards, at the recorded poses in one go, when its data is "
		"warm in the caches.");
	if (!scenes.empty())
		report.paragraph("Scheduling: " + scenes.front().hand().scheduling + ". Memory: " + scenes.front().hand().memory + ".");
	std::vector<std::string> head = {"Quantity"};
	Chart periods{"Histogram of the period of the force thread, bins of 20 \xC2\xB5s; the last one holds all longer ones", "period [ms]",
		"share of ticks [%]", {}};
	for (const PaperScene& s : scenes)
	{
		head.push_back(s.run.scene.name);
		periods.series.push_back(histogram(s));
	}
	head.push_back("Unit");
	report.table(head, paperRows(scenes));
	for (const PaperScene& s : scenes) addScene(report, s);
	report.heading("Period of the force thread");
	report.chart(periods);
	return report;
}

std::string paperJson(const std::vector<PaperScene>& scenes)
{
	using Json = JsonValue;
	const auto spread = [](const PaperScene::Spread& s, double unit) {
		return Json{{"mean", s.mean * unit}, {"p50", s.p50 * unit}, {"p999", s.p999 * unit}, {"max", s.max * unit}};
	};
	Json json = {{"schema", 1}, {"ok", true}, {"scenes", Json::list()}};
	for (const PaperScene& s : scenes)
	{
		if (!s.run.ok()) json["ok"] = false;
		json["scenes"].append({{"scene", s.run.scene.name}, {"ok", s.run.ok()}, {"ticks", s.hand().ticks.size()},
			{"force_rate_hz", s.forceRate}, {"contact_rate_hz", s.contactRate}, {"slowest_force_rate_hz", s.slowestForceRate},
			{"slowest_contact_rate_hz", s.slowestContactRate}, {"period_s", spread(s.period, 1)}, {"force_thread_us", spread(s.tick, 1)},
			{"device_us", spread(s.device, 1)}, {"asked_us", spread(s.asked, 1)}, {"contact_thread_us", spread(s.answer, 1)},
			{"query_us", spread(s.query, 1)}, {"pairs", spread(s.touchingPairs, 1)}, {"overhead_share_of_tick", s.overhead},
			{"overhead_share_of_tick_warm", s.overheadWarm}, {"waking_share_of_tick", s.waking}, {"max_force_n", s.hand().maxForce},
			{"scheduling", s.hand().scheduling}});
	}
	return json.dump();
}

std::string paperCsv(const PaperScene& scene)
{
	std::string text = "time_s,period_s,force_thread_us,pairs,answer,contact_thread_us,query_us,force_n\n";
	const std::vector<SceneTick>& ticks = scene.hand().ticks;
	for (size_t i = 0; i < ticks.size(); ++i)
	{
		const SceneTick& t = ticks[i];
		text += formatFixed(t.time, 6) + "," + formatFixed(t.period, 9) + "," + formatFixed(t.threadMicroseconds, 3) + "," +
			std::to_string(t.answer.pairs) + "," + std::to_string(t.answer.number) + ",";
		text += isNewAnswer(ticks, i) ? formatFixed(t.answer.threadMicroseconds, 3) + "," + formatFixed(scene.bareQuery[i], 3) : ",";
		text += "," + formatNumber(norm(t.wrench.force), 6) + "\n";
	}
	return text;
}
}  // namespace scenes
