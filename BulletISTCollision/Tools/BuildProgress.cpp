// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/BuildProgress.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace ist::tools
{
namespace
{
// Times of one thread [s], fitted to a cube and the bunny (69,666 triangles) with 1,000 to 100,000 spheres. Time per triangle:
constexpr double kImport = 1.5e-6, kRepair = 3.3e-6, kSeed = 6e-6, kFirstSpheres = 1.2e-5, kSampleTriangle = 1.1e-5;
// Time per sphere:
constexpr double kPack = 8.5e-5, kSampleSphere = 1.1e-4, kTree = 1.6e-5, kWrite = 5e-7;
// Constant time:
constexpr double kRead = 0.05, kSampleAny = 0.4, kTreeAny = 0.07;
/// Bytes of a triangle in an OBJ file, including its share of the corners; other formats take half to twice that.
constexpr double kBytesPerTriangle = 35;
}  // namespace

BuildProgress::BuildProgress(double triangles, double spheres, int threads)
{
	const double pool = std::max(1, threads);
	m_stages = {{{"import", 0, kRead + kImport * triangles}, {"repair", 0, kRepair * triangles},
		{"packing", kSeed * triangles / pool, (kFirstSpheres * triangles + kPack * spheres) / pool},
		{"cells", 0, (kSampleAny + kSampleTriangle * triangles + kSampleSphere * spheres) / pool},
		{"tree", 0, (kTreeAny + kTree * spheres) / pool}, {"write", 0, kWrite * spheres}}};
}

double BuildProgress::done(const char* stage, double fraction) const
{
	fraction = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
	double before = 0, all = 0;
	bool reached = false;
	for (const Stage& s : m_stages)
	{
		const bool here = std::strcmp(s.name, stage) == 0;
		reached = reached || here;
		if (here) before = all + (fraction > 0 ? s.start + fraction * s.rest : 0);
		all += s.start + s.rest;
	}
	return reached ? before / all : 0;
}

double likelyTriangles(double bytes) { return bytes / kBytesPerTriangle; }
}  // namespace ist::tools
