// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/bench/motion/MotionRun.h"

#include <map>
#include <string>

namespace bench
{
/// Recorded runs in a folder, one file for each, so that a sweep can be interrupted and goes on where it was. A run of the other precision
/// of Bullet can be read, but not made.
class MotionRecords
{
public:
	explicit MotionRecords(std::string folder) : m_folder(std::move(folder)) {}

	/// The run with these settings: read, or made and written.
	ist::Result<MotionRun> run(const MotionEntry& entry, const MotionSettings& settings);
	/// The run with these settings, if it was made before. `isDouble`: in double precision.
	std::optional<MotionRun> find(const MotionEntry& entry, const MotionSettings& settings, bool isDouble) const;
	/// The prepared scene, with so many spheres in each tree; 0: its own number.
	ist::Result<MotionScene*> scene(const MotionEntry& entry, int spheres = 0);

	/// Whether this program steps in double precision.
	static bool isDouble();

private:
	std::string pathOf(const MotionEntry& entry, const MotionSettings& settings, bool isDouble) const;

	std::string m_folder;
	std::map<std::string, std::unique_ptr<MotionScene>> m_scenes;
	std::map<std::string, bool> m_hasLevels;
};
}  // namespace bench
