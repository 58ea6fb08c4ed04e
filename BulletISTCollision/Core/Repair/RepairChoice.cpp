// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/RepairChoice.h"

namespace ist
{
std::string repairText(const RepairChoice& choice)
{
	switch (choice.mode)
	{
	case RepairMode::Off: return "off";
	case RepairMode::Wrap: return "wrap";
	case RepairMode::Ground: return groundText(choice.ground);
	default: return "auto";
	}
}

std::optional<RepairChoice> repairChoice(const std::string& text)
{
	for (const RepairMode mode : {RepairMode::Auto, RepairMode::Off, RepairMode::Wrap})
		if (text == repairText({mode, {}})) return RepairChoice{mode, {}};
	const std::optional<GroundClosing> ground = groundFromText(text);
	return ground ? std::optional(RepairChoice{RepairMode::Ground, *ground}) : std::nullopt;
}
}  // namespace ist
