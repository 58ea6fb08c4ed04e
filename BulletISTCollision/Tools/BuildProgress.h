// SPDX-License-Identifier: Zlib
#pragma once

#include <array>

namespace ist::tools
{
/// How much of the time of a whole build its stages take, from what is known when it begins. Holds for builds that end at a number of
/// spheres.
class BuildProgress
{
public:
	BuildProgress(double triangles, double spheres, int threads);
	/// Share of the time, 0..1, that is over when `fraction` of `stage` (Progress.h) is.
	double done(const char* stage, double fraction) const;

private:
	/// Seconds on a machine of two cores; only their ratios count.
	struct Stage
	{
		const char* name = "";
		double start = 0;  ///< before its fraction leaves 0
		double rest = 0;
	};
	std::array<Stage, 6> m_stages;
};

/// Triangles that a mesh file of so many bytes may hold.
double likelyTriangles(double bytes);
}  // namespace ist::tools
