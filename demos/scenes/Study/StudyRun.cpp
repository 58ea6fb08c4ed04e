// SPDX-License-Identifier: Zlib
#include "demos/scenes/Study/StudyRun.h"

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Json/JsonValue.h"
#include "demos/scenes/Pages/CsvCells.h"
#include "demos/scenes/Scene/SceneReport.h"
#include "demos/scenes/Study/StudyOrder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
namespace fs = std::filesystem;
using Kind = StudyEvent::Kind;

constexpr double kAfter = 0.01;  // time in which a trial that reached its limit comes to its end [s]
constexpr const char* kUnfinished = ".unfinished";
constexpr const char* kTrialsHead =
	"study,version,seed,participant,block,trial,condition,scene,device,wait_s,duration_s,ended_by,right,mean_force_n,max_force_n,"
	"hand_path_m,contact_s,faulted,device_errors,overruns\n";
constexpr const char* kSamplesHead =
	"participant,trial,hand,time_s,hand_x,hand_y,hand_z,hand_qx,hand_qy,hand_qz,hand_qw,tool_x,tool_y,tool_z,tool_qx,tool_qy,tool_qz,"
	"tool_qw,force_x,force_y,force_z,torque_x,torque_y,torque_z,overlap_m3,contacts\n";

/// Watches the ticks of a run for the begin and the end of a trial. While a button is awaited to begin, the device of the first hand gets
/// no force; those of others do.
class TrialWatch
{
public:
	explicit TrialWatch(const Study& study) : m_study(study) {}

	/// Looks at a tick. Returns false in the tick after the end of the trial. Allocates nothing.
	bool look(SteppingThread& thread, const SceneWorld& world)
	{
		++m_tick;
		// The run ends a tick after the trial: the last tick of a run sends zero.
		if (ended()) return false;
		begun() ? awaitEnd(thread, world) : awaitBegin(thread, world);
		m_buttons = thread.state().buttons;
		m_others.fill(nullptr);
		for (int i = 0; i < thread.step().contactCount; ++i) m_others[static_cast<size_t>(i)] = thread.step().contacts[i].other;
		return begun() || !m_late;
	}

	bool begun() const { return m_begin >= 0; }
	bool ended() const { return m_end >= 0; }
	/// Numbers of the ticks in which the trial began and ended, or else of the last one.
	size_t beginTick(size_t ticks) const { return begun() ? static_cast<size_t>(m_begin) : ticks - 1; }
	size_t endTick(size_t ticks) const { return ended() ? static_cast<size_t>(m_end) : ticks - 1; }
	/// What ended the trial: "button 1", the name of a body, "time limit", "no begin", or "device" where the run ended before.
	std::string endedBy() const
	{
		if (m_late) return begun() ? "time limit" : "no begin";
		if (!ended()) return "device";
		return m_study.end.kind == Kind::Button ? "button " + std::to_string(m_study.end.button) : m_touched;
	}

private:
	/// Whether the event is new in this tick. What is held or touched from the start is not.
	bool happens(const StudyEvent& event, SteppingThread& thread, const SceneWorld& world)
	{
		if (m_tick == 0 || event.kind == Kind::None) return false;
		if (event.kind == Kind::Button) return (thread.state().buttons & ~m_buttons) >> (event.button - 1) & 1U;
		const ToolStep& step = thread.step();
		for (int i = 0; i < step.contactCount; ++i)
		{
			const void* other = step.contacts[i].other;
			if (std::find(m_others.begin(), m_others.end(), other) != m_others.end()) continue;
			m_touched = world.nameOf(other);
			if (event.bodies.empty() || std::find(event.bodies.begin(), event.bodies.end(), m_touched) != event.bodies.end()) return true;
		}
		return false;
	}
	void awaitBegin(SteppingThread& thread, const SceneWorld& world)
	{
		// Where the trial begins in another way, a hook of the scene may have switched the forces off.
		const bool byButton = m_study.begin.kind == Kind::Button;
		if (m_tick == 0) m_since = thread.state().sampledAt;
		if (m_study.begin.kind == Kind::None || happens(m_study.begin, thread, world))
		{
			m_begin = m_tick;
			m_since = thread.state().sampledAt;
			if (byButton) thread.enableForces(true);
			return;
		}
		if (byButton) thread.enableForces(false);
		m_late = reached(thread, m_study.waitLimit);
	}
	void awaitEnd(SteppingThread& thread, const SceneWorld& world)
	{
		const bool ends = happens(m_study.end, thread, world);
		m_late = !ends && reached(thread, m_study.timeLimit);
		if (ends || m_late) m_end = m_tick;
	}
	bool reached(SteppingThread& thread, double limit) const
	{
		return static_cast<double>(thread.state().sampledAt - m_since) >= 1e9 * limit;
	}

	const Study& m_study;
	std::uint32_t m_buttons = 0;                           // in the tick before
	std::array<const void*, kMaxToolContacts> m_others{};  // bodies that the tool touched in the tick before
	const char* m_touched = nullptr;                       // name of the body whose contact was the last event
	std::int64_t m_tick = -1, m_begin = -1, m_end = -1;
	std::int64_t m_since = 0;  // time of the first tick or of the beginning [ns]
	bool m_late = false;
};

/// The two files of a participant, as text that grows by a trial at a time.
class StudyResults
{
public:
	StudyResults(const Study& study, const StudyRunOptions& options)
		: m_study(study),
		  m_participant(std::to_string(options.participant)),
		  m_stem((fs::path(options.folder) / (study.name + "-p" + m_participant)).string())
	{}

	std::string trialsFile() const { return m_stem + "-trials.csv"; }
	std::string samplesFile() const { return m_stem + "-samples.csv"; }
	std::string unfinished() const { return trialsFile() + kUnfinished + " and " + samplesFile() + kUnfinished; }

	/// Why the files cannot be written, or would replace others.
	std::optional<Error> obstacle() const
	{
		for (const std::string& file : {trialsFile(), samplesFile(), trialsFile() + kUnfinished, samplesFile() + kUnfinished})
		{
			std::error_code failed;
			if (fs::exists(fs::symlink_status(file, failed)))
				return Error{file + " is there already: move it away, or name another participant or folder"};
			if (auto refused = whyNotWritable(file)) return refused;
		}
		return std::nullopt;
	}

	/// Adds a trial and its samples, and writes all finished trials to the unfinished files.
	std::optional<Error> add(const StudyTrial& trial, const TrialWatch& watch, const SceneOutcome& run, const SceneWorld& world)
	{
		addTrial(trial);
		const std::vector<SceneTick>& first = run.hands.front().ticks;
		for (size_t i = 0; watch.begun() && i < run.hands.size(); ++i)
		{
			const SceneHand& hand = run.scene.hands[i];
			// Each hand counts from its own first tick.
			const double later = run.hands[i].begun - run.hands.front().begun, begin = first[watch.beginTick(first.size())].time - later,
						 end = first[watch.endTick(first.size())].time - later;
			addSamples(trial, run.hands[i], begin, end, hand.parts ? Pose() : inverse(world.body(hand.tool).X_MP));
		}
		if (auto refused = write(trialsFile() + kUnfinished, m_trials)) return refused;
		return write(samplesFile() + kUnfinished, m_samples);
	}

	/// Gives the unfinished files the names of the results.
	std::optional<Error> finish() const
	{
		std::error_code failed, ignored;
		fs::rename(samplesFile() + kUnfinished, samplesFile(), failed);
		if (failed) return Error{"cannot make " + samplesFile() + ": " + failed.message()};
		fs::rename(trialsFile() + kUnfinished, trialsFile(), failed);
		if (!failed) return std::nullopt;
		fs::rename(samplesFile(), samplesFile() + kUnfinished, ignored);
		return Error{"cannot make " + trialsFile() + ": " + failed.message()};
	}

private:
	static std::optional<Error> write(const std::string& path, const std::string& text)
	{
		const auto written = writeFileAtomically(path, reinterpret_cast<const std::byte*>(text.data()), text.size());
		return written ? std::nullopt : std::optional(written.error());
	}

	void addTrial(const StudyTrial& t)
	{
		const StudyCondition& condition = m_study.conditions[t.condition];
		const auto whole = [](auto value) { return "," + std::to_string(value); };
		m_trials += csvText(m_study.name) + "," + BULLETHAPTICS_VERSION + whole(m_study.seed) + "," + m_participant + whole(t.block) +
			whole(t.number) + "," + csvText(condition.name) + "," + csvText(condition.scene.name) + "," + csvText(t.device) +
			csvCells({t.wait, t.duration}) + "," + csvText(t.endedBy) + "," + isRight(m_study, t) +
			csvCells({t.meanForce, t.maxForce, t.path, t.contact}) + whole(int(t.faulted)) + whole(t.deviceErrors) + whole(t.overruns) +
			"\n";
	}

	/// Adds the ticks of a hand from `begin` to `end` [s].
	void addSamples(const StudyTrial& trial, const SceneHandRun& hand, double begin, double end, const Pose& X_PM)
	{
		const auto every = static_cast<size_t>(std::lround(1000 / m_study.sampleRate));
		size_t ticks = 0;
		for (const SceneTick& tick : hand.ticks)
		{
			if (tick.time < begin || tick.time > end || ticks++ % every != 0) continue;
			const Wrench& w = tick.wrench;
			m_samples += m_participant + "," + std::to_string(trial.number) + "," + csvText(hand.name) + csvCells({tick.time - begin}) +
				csvPose(tick.hand) + csvPose(tick.tool * X_PM) +
				csvCells({w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z, tick.volume}) + "," +
				std::to_string(tick.contacts) + "\n";
		}
	}

	const Study& m_study;
	std::string m_participant, m_stem, m_trials = kTrialsHead, m_samples = kSamplesHead;
};

/// Measures of the ticks from the beginning to the end of a trial.
void measure(const TrialWatch& watch, const SceneHandRun& run, StudyTrial& trial)
{
	trial.device = run.device;
	trial.overruns = run.overruns;
	trial.deviceErrors = run.deviceErrors;
	trial.endedBy = watch.endedBy();
	const std::vector<SceneTick>& ticks = run.ticks;
	if (ticks.empty()) return;
	const size_t begin = watch.beginTick(ticks.size()), end = watch.endTick(ticks.size());
	trial.wait = ticks[begin].time;
	if (!watch.begun()) return;
	trial.duration = ticks[end].time - ticks[begin].time;
	for (size_t i = begin; i <= end; ++i)
	{
		const double force = norm(ticks[i].wrench.force);
		trial.maxForce = std::max(trial.maxForce, force);
		trial.meanForce += force / static_cast<double>(end - begin + 1);
		if (i == begin) continue;
		trial.path += distance(ticks[i].hand.translation, ticks[i - 1].hand.translation);
		if (ticks[i].contacts > 0) trial.contact += ticks[i].period;
	}
}

/// What the experimenter reads before a trial; it does not give the condition away.
std::string callFor(const Study& study, const StudyTrial& trial)
{
	const size_t all = static_cast<size_t>(study.repetitions) * study.conditions.size();
	std::string call = "trial " + std::to_string(trial.number) + " of " + std::to_string(all);
	if (study.begin.kind == Kind::Button) call += ": it begins with button " + std::to_string(study.begin.button);
	if (study.begin.kind == Kind::Contact) call += ": it begins with a touch";
	return call;
}

/// Runs one trial. The value is false after an interruption.
Result<bool> runTrial(const Study& study, const StudyRunOptions& options, StudyResults& results, StudyTrial& trial)
{
	Scene scene = study.conditions[trial.condition].scene;
	scene.duration = study.timeLimit + (study.begin.kind == Kind::None ? 0 : study.waitLimit) + kAfter;
	TrialWatch watch(study);
	SceneRunOptions run = options.run;
	run.listener = [&watch](SteppingThread& thread, const SceneWorld& world) { return watch.look(thread, world); };
	// The bar would count to the limits of the trial, which mostly ends before.
	run.build.progress = [&options](const char* stage, double share) {
		return std::string(stage) == "hand" || !options.run.build.progress || options.run.build.progress(stage, share);
	};
	if (run.build.say) run.build.say(callFor(study, trial));
	std::unique_ptr<SceneWorld> world;
	const Result<SceneOutcome> outcome = runScene(scene, run, &world);
	if (!outcome) return outcome.error();
	if (outcome.value().interrupted) return false;
	measure(watch, outcome.value().hands.front(), trial);
	for (const SceneHandRun& hand : outcome.value().hands) trial.faulted = trial.faulted || hand.faulted || !hand.finite;
	if (auto refused = results.add(trial, watch, outcome.value(), *world)) return *refused;
	return true;
}
}  // namespace

Result<StudyOutcome> runStudy(const Study& study, const StudyRunOptions& options)
{
	StudyResults results(study, options);
	if (auto refused = results.obstacle()) return *refused;
	StudyOutcome outcome;
	outcome.study = study;
	outcome.participant = options.participant;
	const auto kept = [&] { return outcome.trials.empty() ? "" : "; the finished trials are in " + results.unfinished(); };
	const auto stopped = [&](Error error) { return Error{error.message + kept(), error.cancelled}; };
	for (int block = 0; block < study.repetitions; ++block)
		for (const int condition : studyOrder(static_cast<int>(study.conditions.size()), options.participant - 1, block, study.seed))
		{
			StudyTrial trial;
			trial.block = block + 1;
			trial.number = static_cast<int>(outcome.trials.size()) + 1;
			trial.condition = static_cast<size_t>(condition);
			const Result<bool> went = runTrial(study, options, results, trial);
			if (!went) return stopped(went.error());
			outcome.interrupted = !went.value();
			if (outcome.interrupted && options.run.build.say) options.run.build.say("interrupted" + kept());
			if (outcome.interrupted) return outcome;
			outcome.trials.push_back(std::move(trial));
		}
	if (auto refused = results.finish()) return stopped(*refused);
	outcome.trialsFile = results.trialsFile();
	outcome.samplesFile = results.samplesFile();
	return outcome;
}

bool StudyOutcome::ok() const
{
	return !trialsFile.empty() && std::all_of(trials.begin(), trials.end(), [](const StudyTrial& trial) {
		return !trial.faulted && trial.endedBy != "no begin" && trial.endedBy != "device";
	});
}

std::string isRight(const Study& study, const StudyTrial& trial)
{
	const std::string& answer = study.conditions[trial.condition].answer;
	return answer.empty() ? "" : answer == trial.endedBy ? "yes" : "no";
}

std::vector<std::vector<std::string>> summaryRows(const StudyOutcome& o)
{
	const char* result = o.interrupted ? "interrupted" : o.ok() ? "ok" : "FAILED";
	std::vector<std::vector<std::string>> rows = {{"Result", result, ""}, {"Participant", std::to_string(o.participant), ""}};
	for (const StudyTrial& trial : o.trials)
	{
		const std::string name = "Trial " + std::to_string(trial.number) + ", " + o.study.conditions[trial.condition].name;
		rows.push_back({name, formatNumber(trial.duration), "s, ended by " + trial.endedBy});
	}
	if (!o.trialsFile.empty()) rows.push_back({"Trials", o.trialsFile, ""}), rows.push_back({"Samples", o.samplesFile, ""});
	return rows;
}

std::string makeJson(const StudyOutcome& o)
{
	JsonValue json = {{"schema", 1}, {"study", o.study.name}, {"version", BULLETHAPTICS_VERSION}, {"ok", o.ok()},
		{"interrupted", o.interrupted}, {"seed", o.study.seed}, {"participant", o.participant}, {"trials_file", o.trialsFile},
		{"samples_file", o.samplesFile}, {"trials", JsonValue::list()}};
	for (const StudyTrial& t : o.trials)
		json["trials"].append({{"trial", t.number}, {"condition", o.study.conditions[t.condition].name}, {"duration_s", t.duration},
			{"ended_by", t.endedBy}, {"right", isRight(o.study, t)}});
	return json.dump();
}
}  // namespace scenes
