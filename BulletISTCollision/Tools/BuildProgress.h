// SPDX-License-Identifier: Zlib
#pragma once

#include <array>

namespace ist::tools
{
/// Shares of a build's time that its stages take, estimated when it begins. Valid for builds that end at a number of spheres.
class BuildProgress
{
public:
	BuildProgress(double triangles, double spheres, int threads);
	/// Share of the total time, 0..1, that has passed when `fraction` of `stage` (Progress.h) is done.
	double done(const char* stage, double fraction) const;

private:
	/// Times on a machine with two cores [s]; only their ratios matter.
	struct Stage
	{
		const char* name = "";
		double start = 0;  ///< time until its fraction leaves 0
		double rest = 0;
	};
	std::array<Stage, 6> m_stages;
};

/// Number of triangles that a mesh file of this size may contain.
double likelyTriangles(double bytes);
}  // namespace ist::tools
