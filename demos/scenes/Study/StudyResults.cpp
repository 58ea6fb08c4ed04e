// SPDX-License-Identifier: Zlib
#include "demos/scenes/Study/StudyResults.h"

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Base/Version.h"
#include "demos/scenes/Pages/CsvCells.h"
#include "demos/scenes/Scene/SceneReport.h"

#include <cmath>
#include <filesystem>

using namespace ist;

namespace scenes
{
namespace
{
constexpr const char* kTrialsHead =
	"study,version,seed,participant,block,trial,condition,scene,device,wait_s,duration_s,ended_by,right,mean_force_n,max_force_n,"
	"hand_path_m,contact_s,faulted,device_errors,overruns\n";
constexpr const char* kSamplesHead = "participant,trial,hand,time_s,hand_x,hand_y,hand_z,hand_qx,hand_qy,hand_qz,hand_qw,tool_x,tool_y,"
									 "tool_z,tool_qx,tool_qy,tool_qz,tool_qw,"
									 "force_x,force_y,force_z,torque_x,torque_y,torque_z,overlap_m3,contacts\n";

std::optional<Error> write(const std::string& path, const std::string& text)
{
	const auto written = writeFileAtomically(path, reinterpret_cast<const std::byte*>(text.data()), text.size());
	return written ? std::nullopt : std::optional(written.error());
}
}  // namespace

StudyResults::StudyResults(const Study& study, const StudyRunOptions& options)
	: m_study(study),
	  m_options(options),
	  m_trials(kTrialsHead),
	  m_samples(kSamplesHead)
{
	const std::string stem = (std::filesystem::path(options.folder) / (study.name + "-p" + std::to_string(options.participant))).string();
	m_trialsFile = stem + "-trials.csv";
	m_samplesFile = stem + "-samples.csv";
}

std::optional<Error> StudyResults::obstacle() const
{
	for (const std::string& file : {m_trialsFile, m_samplesFile, m_trialsFile + kUnfinished, m_samplesFile + kUnfinished})
	{
		std::error_code failed;
		if (std::filesystem::exists(std::filesystem::symlink_status(file, failed)))
			return Error{file + " is there already: move it away, or name another participant or folder"};
		if (auto refused = whyNotWritable(file)) return refused;
	}
	return std::nullopt;
}

std::string StudyResults::trialRow(const StudyTrial& t) const
{
	const StudyCondition& condition = m_study.conditions[t.condition];
	const auto whole = [](auto value) { return "," + std::to_string(value); };
	return csvText(m_study.name) + "," + BULLETHAPTICS_VERSION + whole(m_study.seed) + whole(m_options.participant) + whole(t.block) +
		whole(t.number) + "," + csvText(condition.name) + "," + csvText(condition.scene.name) + "," + csvText(t.device) +
		csvCells({t.wait, t.duration}) + "," + csvText(t.endedBy) + "," + isRight(m_study, t) +
		csvCells({t.meanForce, t.maxForce, t.path, t.contact}) + whole(int(t.faulted)) + whole(t.deviceErrors) + whole(t.overruns) + "\n";
}

void StudyResults::addSamples(const StudyTrial& trial, const SceneHandRun& hand, double begin, double end, const Pose& X_PM)
{
	const auto every = static_cast<size_t>(std::lround(1000 / m_study.sampleRate));
	size_t ticks = 0;
	for (const SceneTick& tick : hand.ticks)
	{
		if (tick.time < begin || tick.time > end || ticks++ % every != 0) continue;
		const Wrench& w = tick.wrench;
		m_samples += std::to_string(m_options.participant) + "," + std::to_string(trial.number) + "," + csvText(hand.name) +
			csvCells({tick.time - begin}) + csvPose(tick.hand) + csvPose(tick.tool * X_PM) +
			csvCells({w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z, tick.volume}) + "," +
			std::to_string(tick.contacts) + "\n";
	}
}

std::optional<Error> StudyResults::add(const StudyTrial& trial, const TrialWatch& watch, const SceneOutcome& run, const SceneWorld& world)
{
	m_trials += trialRow(trial);
	const std::vector<SceneTick>& first = run.hands.front().ticks;
	for (size_t i = 0; watch.begun() && i < run.hands.size(); ++i)
	{
		const SceneHand& hand = run.scene.hands[i];
		const size_t end = watch.ended() ? static_cast<size_t>(watch.endTick()) : first.size() - 1;
		// Each hand counts from its own first tick.
		const double later = run.hands[i].begun - run.hands.front().begun;
		addSamples(trial, run.hands[i], first[static_cast<size_t>(watch.beginTick())].time - later, first[end].time - later,
			hand.parts ? Pose() : inverse(world.body(hand.tool).X_MP));
	}
	if (auto refused = write(m_trialsFile + kUnfinished, m_trials)) return refused;
	return write(m_samplesFile + kUnfinished, m_samples);
}

std::optional<Error> StudyResults::finish()
{
	if (auto refused = write(m_samplesFile, m_samples)) return refused;
	std::error_code ignored;
	if (auto refused = write(m_trialsFile, m_trials))
	{
		std::filesystem::remove(m_samplesFile, ignored);
		return refused;
	}
	for (const std::string& file : {m_trialsFile, m_samplesFile}) std::filesystem::remove(file + kUnfinished, ignored);
	return std::nullopt;
}
}  // namespace scenes
