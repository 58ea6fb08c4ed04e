// SPDX-License-Identifier: Zlib
#include "demos/browser/base/Threads.h"

#include <algorithm>
#include <cmath>
#include <functional>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr uint32_t kSegments = 96;  ///< number of segments around the axis, which include the corners of a hexagon

/// A ring of points around y at one height, with the radius as a function of the angle.
struct Ring
{
	double height = 0;
	std::function<double(double)> radius;
};

double around(uint32_t segment) { return 2 * kPi * segment / kSegments; }

std::vector<Ring> threadRings(const Thread& thread, double wider, double from, double to)
{
	std::vector<Ring> rings;
	const int rows = static_cast<int>(std::ceil((to - from) * thread.starts / thread.lead * 24));
	for (int i = 0; i <= rows; ++i)
	{
		const double y = from + (to - from) * i / rows;
		rings.push_back({y, [=](double phi) {
							 return thread.radius + wider + thread.depth * std::sin(thread.starts * (2 * kPi * y / thread.lead - phi));
						 }});
	}
	return rings;
}

Mesh pointsOf(const std::vector<Ring>& rings)
{
	Mesh mesh;
	for (const Ring& ring : rings)
		for (uint32_t s = 0; s < kSegments; ++s)
		{
			const double r = ring.radius(around(s));
			mesh.vertices.push_back({r * std::cos(around(s)), ring.height, -r * std::sin(around(s))});
		}
	return mesh;
}

/// Adds the band between two rings. It is seen from outside when `above` lies above `below`.
void addBand(Mesh& mesh, uint32_t below, uint32_t above)
{
	for (uint32_t s = 0; s < kSegments; ++s)
	{
		const uint32_t next = (s + 1) % kSegments, a = below * kSegments, b = above * kSegments;
		mesh.triangles.push_back({a + s, a + next, b + next});
		mesh.triangles.push_back({a + s, b + next, b + s});
	}
}

void addCap(Mesh& mesh, uint32_t ring, double height, bool above)
{
	const uint32_t centre = static_cast<uint32_t>(mesh.vertices.size());
	mesh.vertices.push_back({0, height, 0});
	for (uint32_t s = 0; s < kSegments; ++s)
	{
		const uint32_t a = ring * kSegments + s, b = ring * kSegments + (s + 1) % kSegments;
		if (above) mesh.triangles.push_back({centre, a, b});
		else mesh.triangles.push_back({centre, b, a});
	}
}
}  // namespace

Mesh screw(const Thread& thread, double length, double headRadius, double headHeight)
{
	std::vector<Ring> rings = threadRings(thread, 0, -length, 0);
	const auto head = [=](double) { return headRadius; };
	rings.push_back({0, head});
	rings.push_back({headHeight, head});
	Mesh mesh = pointsOf(rings);
	const uint32_t last = static_cast<uint32_t>(rings.size()) - 1;
	for (uint32_t i = 0; i < last; ++i) addBand(mesh, i, i + 1);
	addCap(mesh, 0, -length, false);
	addCap(mesh, last, headHeight, true);
	return mesh;
}

Mesh nut(const Thread& thread, double clearance, double width, double height)
{
	// The rings go once around the section: down the hole, then up the outside.
	std::vector<Ring> rings = threadRings(thread, clearance, -0.5 * height, 0.5 * height);
	std::reverse(rings.begin(), rings.end());
	const auto hexagon = [=](double phi) { return 0.5 * width / std::cos(std::remainder(phi, kPi / 3)); };
	rings.push_back({-0.5 * height, hexagon});
	rings.push_back({0.5 * height, hexagon});
	Mesh mesh = pointsOf(rings);
	const uint32_t count = static_cast<uint32_t>(rings.size());
	for (uint32_t i = 0; i < count; ++i) addBand(mesh, i, (i + 1) % count);
	return mesh;
}
}  // namespace browser
