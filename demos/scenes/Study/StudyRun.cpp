// SPDX-License-Identifier: Zlib
#include "demos/scenes/Study/StudyRun.h"

#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Json/JsonValue.h"
#include "demos/scenes/Pages/HtmlReport.h"
#include "demos/scenes/Study/StudyOrder.h"
#include "demos/scenes/Study/StudyResults.h"
#include "demos/scenes/Study/TrialWatch.h"

#include <algorithm>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kAfter = 0.01;  // time in which a trial that reached its limit comes to its end [s]

/// Measures of the ticks from the beginning to the end of a trial.
void measure(const TrialWatch& watch, const SceneHandRun& run, StudyTrial& trial)
{
	trial.device = run.device;
	trial.overruns = run.overruns;
	trial.deviceErrors = run.deviceErrors;
	trial.endedBy = watch.endedBy();
	if (trial.endedBy.empty()) trial.endedBy = "device";
	const std::vector<SceneTick>& ticks = run.ticks;
	if (ticks.empty()) return;
	if (!watch.begun()) trial.wait = ticks.back().time;
	if (!watch.begun()) return;
	const auto begin = static_cast<size_t>(watch.beginTick());
	const size_t end = watch.ended() ? static_cast<size_t>(watch.endTick()) : ticks.size() - 1;
	trial.wait = ticks[begin].time;
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
	if (study.begin.kind == StudyEvent::Kind::Button) call += ": it begins with button " + std::to_string(study.begin.button);
	if (study.begin.kind == StudyEvent::Kind::Contact) call += ": it begins with a touch";
	return call;
}

/// Runs one trial. The value is false after an interruption.
Result<bool> runTrial(const Study& study, const StudyRunOptions& options, StudyResults& results, StudyTrial& trial)
{
	Scene scene = study.conditions[trial.condition].scene;
	scene.duration = study.timeLimit + (study.begin.kind == StudyEvent::Kind::None ? 0 : study.waitLimit) + kAfter;
	TrialWatch watch(study);
	SceneRunOptions run = options.run;
	run.listener = [&watch](devicebridge::SteppingThread& thread, const SceneWorld& world) { return watch.look(thread, world); };
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
	std::vector<std::vector<std::string>> rows = {{"Result",
													  o.interrupted ? "interrupted"
														  : o.ok()  ? "ok"
																	: "FAILED",
													  ""},
		{"Participant", std::to_string(o.participant), ""}};
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
	using Json = JsonValue;
	Json json = {{"schema", 1}, {"study", o.study.name}, {"version", BULLETHAPTICS_VERSION}, {"ok", o.ok()}, {"interrupted", o.interrupted},
		{"seed", o.study.seed}, {"participant", o.participant}, {"trials_file", o.trialsFile}, {"samples_file", o.samplesFile},
		{"trials", Json::list()}};
	for (const StudyTrial& t : o.trials)
		json["trials"].append({{"block", t.block}, {"trial", t.number}, {"condition", o.study.conditions[t.condition].name},
			{"device", t.device}, {"wait_s", t.wait}, {"duration_s", t.duration}, {"ended_by", t.endedBy}, {"right", isRight(o.study, t)},
			{"mean_force_n", t.meanForce}, {"max_force_n", t.maxForce}, {"hand_path_m", t.path}, {"contact_s", t.contact},
			{"faulted", t.faulted}});
	return json.dump();
}
}  // namespace scenes
