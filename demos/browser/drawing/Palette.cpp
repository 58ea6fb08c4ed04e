// SPDX-License-Identifier: Zlib
#include "demos/browser/drawing/Palette.h"

#include <algorithm>
#include <cmath>

namespace browser
{
namespace
{
template <int N> Colour onRamp(const Colour (&ramp)[N], double t)
{
	const double x = std::clamp(t, 0.0, 1.0) * (N - 1);
	const int i = std::min(int(x), N - 2);
	return mixed(ramp[i], ramp[i + 1], x - i);
}

double linear(double srgb) { return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4); }
}  // namespace

Colour bodyColour(int index)
{
	static const Colour colours[kBodyColours] = {{0.337f, 0.706f, 0.914f}, {0.902f, 0.624f, 0.000f}, {0.000f, 0.620f, 0.451f},
		{0.800f, 0.475f, 0.655f}, {0.941f, 0.894f, 0.259f}, {0.000f, 0.447f, 0.698f}, {0.835f, 0.369f, 0.000f}};
	return colours[((index % kBodyColours) + kBodyColours) % kBodyColours];
}

Colour levelColour(double t)
{
	static const Colour ramp[] = {{0.267f, 0.005f, 0.329f}, {0.254f, 0.265f, 0.530f}, {0.164f, 0.471f, 0.558f}, {0.135f, 0.659f, 0.518f},
		{0.478f, 0.821f, 0.318f}, {0.993f, 0.906f, 0.144f}};
	return onRamp(ramp, t);
}

Colour shadeColour(double shade) { return levelColour(0.06 + 0.92 * shade); }

double levelShade(int level) { return std::min(1.0, 0.02 + 0.14 * level); }

Colour pressureColour(double t)
{
	static const Colour ramp[] = {{0.200f, 0.040f, 0.320f}, {0.470f, 0.110f, 0.430f}, {0.735f, 0.216f, 0.330f}, {0.929f, 0.411f, 0.145f},
		{0.984f, 0.650f, 0.140f}, {0.975f, 0.930f, 0.500f}};
	return onRamp(ramp, t);
}

Colour mixed(const Colour& a, const Colour& b, double t)
{
	const float s = float(t);
	return {a.r + s * (b.r - a.r), a.g + s * (b.g - a.g), a.b + s * (b.b - a.b), a.a + s * (b.a - a.a)};
}

double lightness(const Colour& c)
{
	const double y = 0.2126 * linear(c.r) + 0.7152 * linear(c.g) + 0.0722 * linear(c.b);
	return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}
}  // namespace browser
