// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace browser::shaders
{
/// Triangles: models with one pose, or glyphs with one pose each.
std::string solidVertex(), solidFragment(), solidShadowFragment();
/// Balls as squares that face the eye; each pixel computes its intersection with the sphere.
std::string ballVertex(), ballFragment(), ballShadowFragment();
/// Lines with a width in pixels.
std::string lineVertex(), lineFragment();
/// The plane with its grid, or water.
std::string groundVertex(), groundFragment();
/// Passes over the whole picture: background, ambient occlusion, and the composition of both.
std::string screenVertex(), backgroundFragment(), occlusionFragment(), composeFragment();
}  // namespace browser::shaders
