// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/DemoWorld.h"

#include <string>
#include <vector>

namespace browser
{
/// Saves the bodies of a world, as they are now, as a scene file at `path`, which should end in .json, with their trees as .ist files
/// beside it. `tool` is a body that a simulated hand holds in place; null: the scene has no hand. Returns sentences on what a scene file
/// cannot hold. The scene file is written last, and only if it can be read and its world can be made; otherwise it is refused.
ist::Result<std::vector<std::string>> saveScene(DemoWorld& world, const btRigidBody* tool, const std::string& path);
}  // namespace browser
