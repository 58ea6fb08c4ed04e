// SPDX-License-Identifier: Zlib
#pragma once

namespace browser
{
/// sRGB, 0 to 1.
struct Colour
{
	float r = 0, g = 0, b = 0, a = 1;
};

/// Colours of bodies that people with any of the common colour blindnesses can distinguish (Okabe and Ito, Color Universal Design, 2008).
Colour bodyColour(int index);
constexpr int kBodyColours = 7;

/// Colour on a ramp from dark blue over green to yellow, like matplotlib's viridis. Its lightness rises evenly, so it is readable in grey
/// too. `t` is from 0 to 1; other values give the colours of the ends.
Colour levelColour(double t);
/// Colour for things that differ only by colour. `shade` from 0 to 1 runs along levelColour, without its darkest and palest parts.
Colour shadeColour(double shade);
/// Shade of a level of a tree; 0 is the leaves. Neighbouring levels can be distinguished up to level 7; higher ones look like level 7.
double levelShade(int level);
/// Colour for pressure: a ramp from dark purple over red to yellow, with evenly rising lightness.
Colour pressureColour(double t);

Colour mixed(const Colour& a, const Colour& b, double t);
/// CIE L* of a colour, 0 to 100.
double lightness(const Colour& colour);
}  // namespace browser
