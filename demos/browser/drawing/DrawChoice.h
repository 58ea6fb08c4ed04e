// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace browser
{
/// Which of the possible drawings are shown.
struct DrawChoice
{
	bool surfaces = true, spheres = false, sphereLevels = false, leaves = false, levels = false, lenses = false, patches = true,
		 pairs = false, wrenches = true, boxes = false, frames = false, constraints = false, wireframe = false, shadows = true,
		 ground = true;

	/// True when meshes must be transparent.
	bool showsInside() const { return spheres || sphereLevels || leaves || levels || lenses || pairs; }
};

/// One drawing, with its texts for the user.
struct DrawChoiceRow
{
	const char* name;   ///< one word, for the command line
	const char* label;  ///< text with its key
	bool DrawChoice::*member;
};
const std::vector<DrawChoiceRow>& drawChoiceRows();

/// Switches on the drawings in `names`, which are separated by commas, and off those with "no-" before the name. Returns the first
/// unknown name, or an empty text.
std::string applyChoices(const std::string& names, DrawChoice& choice);
}  // namespace browser
