// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include <optional>
#include <string>

namespace ist
{
/// How a mesh is repaired, as options and assets say it in a text.
struct RepairChoice
{
	RepairMode mode = RepairMode::Auto;
	GroundClosing ground;  ///< for RepairMode::Ground
};

/// "auto", "off", "wrap", or groundText().
std::string repairText(const RepairChoice& choice);
/// Reads such a text. Empty optional for other texts.
std::optional<RepairChoice> repairChoice(const std::string& text);
}  // namespace ist
