// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

namespace ist
{
/// A line of an element's plane: { (s, t) : a s + b t = c }.
struct ElementLine
{
	float a, b, c;
	float at(float s, float t) const { return a * s + b * t - c; }
};

/// A quadratic function of an element's coordinates: c + cs s + ct t + (css s^2 + 2 cst s t + ctt t^2) / 2.
struct ElementQuadratic
{
	float c, cs, ct, css, cst, ctt;
	float at(float s, float t) const { return c + s * (cs + 0.5f * css * s + cst * t) + t * (ct + 0.5f * ctt * t); }
	float slopeS(float s, float t) const { return cs + css * s + cst * t; }
	float slopeT(float s, float t) const { return ct + cst * s + ctt * t; }
};

/// Integrals of 1, s, t, s^2, s t and t^2 over a polygon.
struct PolygonMoments
{
	float area = 0, s = 0, t = 0, ss = 0, st = 0, tt = 0;
};

/// A convex polygon in the coordinates (s, t) of a surface element, counter-clockwise.
struct ElementPolygon
{
	static constexpr int kMost = 16;  ///< corners; each cut by a line adds at most one
	float s[kMost], t[kMost];
	int count = 0;

	void add(float newS, float newT)
	{
		s[count] = newS;
		t[count] = newT;
		++count;
	}
	/// Inserts a corner before the one of this index.
	void insert(int index, float newS, float newT)
	{
		for (int i = count++; i > index; --i)
		{
			s[i] = s[i - 1];
			t[i] = t[i - 1];
		}
		s[index] = newS;
		t[index] = newT;
	}
	bool isFull() const { return count >= kMost - 1; }

	/// Splits the polygon: `value[i]` is the signed distance of corner i from the line, to any scale. The parts may be empty.
	void split(const float* value, ElementPolygon& below, ElementPolygon& above) const
	{
		below.count = above.count = 0;
		for (int i = 0, next = 1; i < count; ++i, ++next)
		{
			if (next == count) next = 0;
			if (value[i] <= 0) below.add(s[i], t[i]);
			if (value[i] >= 0) above.add(s[i], t[i]);
			if ((value[i] < 0) != (value[next] < 0) && value[i] != 0 && value[next] != 0)
			{
				const float share = value[i] / (value[i] - value[next]);
				const float x = s[i] + share * (s[next] - s[i]), y = t[i] + share * (t[next] - t[i]);
				below.add(x, y);
				above.add(x, y);
			}
		}
	}

	/// Moments by Green's theorem, about the first corner for accuracy and then shifted to the origin.
	PolygonMoments moments() const
	{
		PolygonMoments m;
		const float s0 = s[0], t0 = t[0];
		for (int i = 1; i + 1 < count; ++i)
		{
			const float as = s[i] - s0, at = t[i] - t0, bs = s[i + 1] - s0, bt = t[i + 1] - t0, w = as * bt - bs * at;
			m.area += w;
			m.s += w * (as + bs);
			m.t += w * (at + bt);
			m.ss += w * (as * as + as * bs + bs * bs);
			m.tt += w * (at * at + at * bt + bt * bt);
			m.st += w * (as * at + bs * bt + 0.5f * (as * bt + bs * at));
		}
		m.area *= 0.5f;
		m.s *= 1 / 6.0f;
		m.t *= 1 / 6.0f;
		m.ss *= 1 / 12.0f;
		m.tt *= 1 / 12.0f;
		m.st *= 1 / 12.0f;
		m.ss += 2 * s0 * m.s + s0 * s0 * m.area;
		m.tt += 2 * t0 * m.t + t0 * t0 * m.area;
		m.st += s0 * m.t + t0 * m.s + s0 * t0 * m.area;
		m.s += s0 * m.area;
		m.t += t0 * m.area;
		return m;
	}
};
}  // namespace ist
