// SPDX-License-Identifier: Zlib
// Study files: any text is refused with the file's name, or gives a study whose scenes can be run.
#include "demos/scenes/Study/StudyFile.h"

#include "tests/fuzz/Invariants.h"

using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const ist::Result<scenes::Study> study = scenes::parseStudy("a.json", fuzz::text(data, size), STUDY_FOLDER);
	if (!fuzz::accepted(study))
	{
		require(study.error().message.starts_with("a.json"), "a refusal names the file");
		return 0;
	}
	const scenes::Study& s = study.value();
	require(s.repetitions > 0 && !s.conditions.empty(), "there is a trial");
	require(std::isfinite(s.timeLimit) && s.timeLimit > 0 && std::isfinite(s.waitLimit) && s.waitLimit > 0, "times are limited");
	require(s.sampleRate > 0 && s.sampleRate <= 1000, "a rate is positive");
	require(s.name.find('/') == std::string::npos && !s.name.empty(), "results stay in their folder");
	for (const scenes::StudyCondition& condition : s.conditions) require(!condition.scene.hands.empty(), "a scene has a hand");
	for (const scenes::StudyEvent* event : {&s.begin, &s.end}) require(event->button >= 1 && event->button <= 32, "an event can be seen");
	return 0;
}
