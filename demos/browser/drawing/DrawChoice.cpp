// SPDX-License-Identifier: Zlib
#include "demos/browser/drawing/DrawChoice.h"

#include <sstream>

namespace browser
{
const std::vector<DrawChoiceRow>& drawChoiceRows()
{
	static const std::vector<DrawChoiceRow> rows = {{"meshes", "meshes (v)", &DrawChoice::surfaces},
		{"spheres", "inner spheres by size (b)", &DrawChoice::spheres},
		{"sphere-levels", "inner spheres by level (e)", &DrawChoice::sphereLevels}, {"leaves", "leaves (n)", &DrawChoice::leaves},
		{"levels", "levels that answer (t)", &DrawChoice::levels}, {"lenses", "lenses by pressure (m)", &DrawChoice::lenses},
		{"patches", "patches, Bullet's contact in grey", &DrawChoice::patches}, {"pairs", "pairs by depth (u)", &DrawChoice::pairs},
		{"forces", "forces (c)", &DrawChoice::wrenches}, {"boxes", "boxes (a)", &DrawChoice::boxes},
		{"frames", "frames (j)", &DrawChoice::frames}, {"constraints", "constraints (k)", &DrawChoice::constraints},
		{"wireframe", "wireframe (w)", &DrawChoice::wireframe}, {"shadows", "shadows (s)", &DrawChoice::shadows},
		{"ground", "ground", &DrawChoice::ground}};
	return rows;
}

std::string applyChoices(const std::string& names, DrawChoice& choice)
{
	std::istringstream all(names);
	for (std::string name; std::getline(all, name, ',');)
	{
		const bool on = name.rfind("no-", 0) != 0;
		bool known = false;
		for (const DrawChoiceRow& row : drawChoiceRows())
			if (row.name == (on ? name : name.substr(3))) choice.*row.member = on, known = true;
		if (!known) return name;
	}
	return {};
}
}  // namespace browser
