// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Scene/SceneRun.h"
#include "demos/scenes/Study/StudyFile.h"

#include <string>
#include <vector>

namespace scenes
{
struct StudyRunOptions
{
	SceneRunOptions run;       ///< its listener is the study's own
	int participant = 1;       ///< number of the participant, from 1
	std::string folder = ".";  ///< where the results are written
};

/// A row of the file of trials. Its events and measures are those of the first hand of the scene.
struct StudyTrial
{
	int block = 0, number = 0;  ///< number of the repetition and of the trial, from 1
	size_t condition = 0;
	double wait = 0, duration = 0;       ///< time before the trial began, and its duration [s]
	std::string endedBy;                 ///< "button 1", the name of a body, "time limit", "no begin" or "device"
	double meanForce = 0, maxForce = 0;  ///< force that was sent to the hand [N]
	double path = 0, contact = 0;        ///< way of the hand [m]; time in which the tool touched something [s]
	bool faulted = false;                ///< a fault kept the force of a hand at zero at the end
	uint64_t overruns = 0, deviceErrors = 0;
	std::string device;  ///< model of the device
};

struct StudyOutcome
{
	Study study;
	int participant = 0;
	std::vector<StudyTrial> trials;
	std::string trialsFile, samplesFile;
	bool interrupted = false;

	/// True when every trial began, none ended with a fault or without its device, and the results were written.
	bool ok() const;
};

/// Runs the trials of a participant. Results are two CSV files, NAME-pN-trials.csv and NAME-pN-samples.csv; either both are complete or
/// neither is there. Until the last trial, the finished ones are in files with the suffix `.unfinished`, which stay after an error and an
/// interruption. Refuses to begin where one of the four files exists.
ist::Result<StudyOutcome> runStudy(const Study& study, const StudyRunOptions& options);

/// "yes", "no", or empty where the condition has no right answer.
std::string isRight(const Study& study, const StudyTrial& trial);
std::vector<std::vector<std::string>> summaryRows(const StudyOutcome& outcome);
std::string makeJson(const StudyOutcome& outcome);
}  // namespace scenes
