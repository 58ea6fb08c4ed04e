// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Study/StudyRun.h"
#include "demos/scenes/Study/TrialWatch.h"

#include <optional>

namespace scenes
{
/// The two files of a participant, as text that grows by a trial at a time.
class StudyResults
{
public:
	StudyResults(const Study& study, const StudyRunOptions& options);

	/// Why the files cannot be written, or would replace others.
	std::optional<ist::Error> obstacle() const;
	/// Adds a trial and its samples, and writes all finished trials to the unfinished files.
	std::optional<ist::Error> add(const StudyTrial& trial, const TrialWatch& watch, const SceneOutcome& run, const SceneWorld& world);
	/// Writes the results and removes the unfinished files.
	std::optional<ist::Error> finish();

	const std::string& trialsFile() const { return m_trialsFile; }
	const std::string& samplesFile() const { return m_samplesFile; }
	std::string unfinished() const { return m_trialsFile + kUnfinished + " and " + m_samplesFile + kUnfinished; }

private:
	static constexpr const char* kUnfinished = ".unfinished";
	std::string trialRow(const StudyTrial& trial) const;
	/// The ticks of a hand from `begin` to `end` [s].
	void addSamples(const StudyTrial& trial, const SceneHandRun& hand, double begin, double end, const ist::Pose& X_PM);

	const Study& m_study;
	const StudyRunOptions& m_options;
	std::string m_trialsFile, m_samplesFile, m_trials, m_samples;
};
}  // namespace scenes
