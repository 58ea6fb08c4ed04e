// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Scene/SceneRun.h"

#include <string>

namespace scenes
{
/// Options of a run in virtual time, with trees that are kept for the next run.
inline SceneRunOptions virtualTimeOptions()
{
	SceneRunOptions options;
	options.virtualTime = true;
	options.build.cache = TREE_FOLDER;
	return options;
}

inline ist::Result<SceneOutcome> runText(const std::string& text)
{
	const ist::Result<Scene> read = parseScene("s.json", text, TREE_FOLDER);
	if (!read) return read.error();
	return runScene(read.value(), virtualTimeOptions());
}
}  // namespace scenes
