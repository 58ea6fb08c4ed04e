// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace browser::shaders
{
/// Triangles: models with one pose, or glyphs with one each.
std::string solidVertex(), solidFragment(), solidShadowFragment();
/// Balls as squares that face the eye, whose pixels find the sphere themselves.
std::string ballVertex(), ballFragment(), ballShadowFragment();
/// Lines of a width in pixels.
std::string lineVertex(), lineFragment();
/// The plane with its grid, or water.
std::string groundVertex(), groundFragment();
/// The whole picture: background, ambient occlusion, and both put together.
std::string screenVertex(), backgroundFragment(), occlusionFragment(), composeFragment();
}  // namespace browser::shaders
