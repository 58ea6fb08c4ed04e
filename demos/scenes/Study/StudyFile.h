// SPDX-License-Identifier: Zlib
#pragma once

#include "TestSupport/SceneFiles/SceneFile.h"

#include <cstdint>
#include <string>
#include <vector>

namespace scenes
{
/// What begins or ends a trial.
struct StudyEvent
{
	enum class Kind
	{
		None,    ///< nothing: a trial begins at once, or lasts until its time limit
		Button,  ///< the button of the device is pressed
		Contact  ///< the tool touches a body that it did not touch in the tick before
	};
	Kind kind = Kind::None;
	int button = 1;                   ///< number of the button, from 1 to 32
	std::vector<std::string> bodies;  ///< for a contact; empty: any body
};

struct StudyCondition
{
	std::string name, sceneFile;
	Scene scene;         ///< the scene with the settings of the condition
	std::string answer;  ///< body whose touch is the right answer; empty: no answer is asked for
};

/// The contents of a study file (data/studies/README.md). SI units.
struct Study
{
	std::string name;
	uint64_t seed = 1;
	int repetitions = 1;
	double sampleRate = 100;                ///< rows a second in the file of samples [Hz]
	double timeLimit = 60, waitLimit = 60;  ///< longest trial, longest wait for its beginning [s]
	StudyEvent begin, end;
	std::vector<StudyCondition> conditions;
};

/// Reads a study and all its scenes. Each error is refused with file name, line and field. A `device` is the address that all scenes get
/// in place of that of their first hand; it moves by itself, and the path is left out. File names in a text are relative to `folder`.
ist::Result<Study> parseStudy(const std::string& name, const std::string& text, const std::string& folder, const std::string& device = {});
ist::Result<Study> loadStudy(const std::string& path, const std::string& device = {});
}  // namespace scenes
