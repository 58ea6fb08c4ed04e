// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace browser
{
/// Which of the things that can be shown are.
struct DrawChoice
{
	bool surfaces = true, spheres = false, sphereLevels = false, leaves = false, levels = false, lenses = false, patches = true,
		 wrenches = true, boxes = false, frames = false, constraints = false, wireframe = false, shadows = true, ground = true;

	/// Meshes must be of glass.
	bool showsInside() const { return spheres || sphereLevels || leaves || levels || lenses; }
};

/// One of them, for people.
struct DrawChoiceRow
{
	const char* name;   ///< one word, for the command line
	const char* label;  ///< with its key
	bool DrawChoice::*member;
};
const std::vector<DrawChoiceRow>& drawChoiceRows();

/// Switches on what `names` lists, separated by commas, and off what has a "no-" before its name. Returns the first that is unknown; empty:
/// none.
std::string applyChoices(const std::string& names, DrawChoice& choice);
}  // namespace browser
