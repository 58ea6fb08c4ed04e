// SPDX-License-Identifier: Zlib
#pragma once

namespace browser
{
/// sRGB, 0 to 1.
struct Colour
{
	float r = 0, g = 0, b = 0, a = 1;
};

/// Colours of bodies that people with any of the common colour blindnesses tell apart (Okabe and Ito, Color Universal Design, 2008).
Colour bodyColour(int index);
constexpr int kBodyColours = 7;

/// A ramp from dark blue over green to yellow, whose lightness rises evenly, so that it also reads in grey (the shape of matplotlib's
/// viridis). `t` from 0 to 1; beyond, the ends.
Colour levelColour(double t);
/// Of what is told apart by colour alone: `shade` from 0 to 1 along levelColour, without its darkest and its palest end.
Colour shadeColour(double shade);
/// Shade of a level of a tree, 0 being the leaves: neighbours can be told apart up to level 7, and those beyond look like that one.
double levelShade(int level);
/// A ramp from dark purple over red to yellow, lightness rising evenly: pressure.
Colour pressureColour(double t);

Colour mixed(const Colour& a, const Colour& b, double t);
/// CIE L* of the colour, 0 to 100.
double lightness(const Colour& colour);
}  // namespace browser
