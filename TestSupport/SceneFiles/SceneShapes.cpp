// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/SceneShapes.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr uint32_t kSectorSteps = 12, kWallSteps = 8;

/// Half the diagonals of a rhombus at the height z.
struct Rhombus
{
	double z, x, y;
};

/// Joins rhombi with equal numbers of corners from the bottom up, and closes both ends with a fan.
Mesh loft(const std::vector<Rhombus>& sections, uint32_t perEdge)
{
	const uint32_t n = 4 * perEdge, count = static_cast<uint32_t>(sections.size());
	Mesh mesh;
	for (const Rhombus& s : sections)
		for (uint32_t i = 0; i < n; ++i)
		{
			// The vertices run along the four edges, from +x counter-clockwise.
			const double u = static_cast<double>(i % perEdge) / perEdge;
			const double corners[5][2] = {{s.x, 0}, {0, s.y}, {-s.x, 0}, {0, -s.y}, {s.x, 0}};
			const auto &from = corners[i / perEdge], &to = corners[i / perEdge + 1];
			mesh.vertices.push_back({from[0] + u * (to[0] - from[0]), from[1] + u * (to[1] - from[1]), s.z});
		}
	const uint32_t bottom = static_cast<uint32_t>(mesh.vertices.size()), top = bottom + 1;
	mesh.vertices.push_back({0, 0, sections.front().z});
	mesh.vertices.push_back({0, 0, sections.back().z});
	const auto at = [n](uint32_t section, uint32_t i) { return section * n + i % n; };
	for (uint32_t i = 0; i < n; ++i)
	{
		mesh.triangles.push_back({bottom, at(0, i + 1), at(0, i)});
		for (uint32_t s = 0; s + 1 < count; ++s)
		{
			mesh.triangles.push_back({at(s, i), at(s, i + 1), at(s + 1, i + 1)});
			mesh.triangles.push_back({at(s, i), at(s + 1, i + 1), at(s + 1, i)});
		}
		mesh.triangles.push_back({top, at(count - 1, i), at(count - 1, i + 1)});
	}
	return mesh;
}

/// Adds intermediate sections, so that triangles do not become needles.
void stretch(std::vector<Rhombus>& sections, const Rhombus& to, int steps)
{
	const Rhombus from = sections.back();
	for (int i = 1; i <= steps; ++i)
	{
		const double u = static_cast<double>(i) / steps;
		sections.push_back({from.z + u * (to.z - from.z), from.x + u * (to.x - from.x), from.y + u * (to.y - from.y)});
	}
}
}  // namespace

double crownHeight(const CrownShape& shape, double angle)
{
	const double sector = 2 * kPi / shape.points;
	const double off = std::fabs(angle - sector * std::round(angle / sector)) / (0.5 * sector * shape.pointShare);
	return shape.bandHeight + shape.pointHeight * std::max(0.0, 1 - off);
}

double crownInside(const CrownShape& shape, double height)
{
	return shape.radius - shape.wall * (1 - 2.0 / 3 * height / (shape.bandHeight + shape.pointHeight));
}

Mesh makeCrownMesh(const CrownShape& shape)
{
	const uint32_t stations = kSectorSteps * static_cast<uint32_t>(std::max(shape.points, 1)), ring = 2 * (kWallSteps + 1);
	Mesh mesh;
	for (uint32_t i = 0; i < stations; ++i)
	{
		const double angle = 2 * kPi * i / stations, top = crownHeight(shape, angle);
		// The section runs up the outside and down the inside.
		for (uint32_t j = 0; j < ring; ++j)
		{
			const uint32_t step = j <= kWallSteps ? j : ring - 1 - j;
			const double z = top * step / kWallSteps, r = j <= kWallSteps ? shape.radius : crownInside(shape, z);
			mesh.vertices.push_back({r * std::cos(angle), r * std::sin(angle), z});
		}
	}
	const auto at = [&](uint32_t i, uint32_t j) { return (i % stations) * ring + j % ring; };
	for (uint32_t i = 0; i < stations; ++i)
		for (uint32_t j = 0; j < ring; ++j)
		{
			mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
			mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
		}
	return mesh;
}

Mesh makeTubeMesh(const TubeShape& shape)
{
	constexpr uint32_t kStations = 96, kSteps = 8;
	const double inside = shape.radius - shape.wall, h = shape.halfLength, c = shape.chamfer;
	// Corners of the section, up the outside and down the inside.
	const double corners[][2] = {{inside, -h}, {shape.radius, -h}, {shape.radius, h}, {inside + c, h}, {inside, h - c}, {inside, -h}};
	std::vector<Vec3> section;
	for (int i = 0; i < 5; ++i)
	{
		const uint32_t steps = i == 1 || i == 4 ? kSteps : 2;
		for (uint32_t k = 0;
			 k < steps && distance(Vec3{corners[i][0], 0, corners[i][1]}, Vec3{corners[i + 1][0], 0, corners[i + 1][1]}) > 0; ++k)
		{
			const double u = static_cast<double>(k) / steps;
			section.push_back(
				{corners[i][0] + u * (corners[i + 1][0] - corners[i][0]), 0, corners[i][1] + u * (corners[i + 1][1] - corners[i][1])});
		}
	}
	const auto ring = static_cast<uint32_t>(section.size());
	Mesh mesh;
	for (uint32_t i = 0; i < kStations; ++i)
		for (const Vec3& p : section)
			mesh.vertices.push_back({p.x * std::cos(2 * kPi * i / kStations), p.x * std::sin(2 * kPi * i / kStations), p.z});
	const auto at = [&](uint32_t i, uint32_t j) { return (i % kStations) * ring + j % ring; };
	for (uint32_t i = 0; i < kStations; ++i)
		for (uint32_t j = 0; j < ring; ++j)
		{
			mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
			mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
		}
	return mesh;
}

Mesh makeSwordMesh(const SwordShape& s)
{
	const double tip = 0.04 * s.blade, guard = s.blade + s.guardHeight, grip = guard + s.grip, end = grip + s.pommelHeight;
	std::vector<Rhombus> sections = {{0, 0.02 * s.halfWidth, 0.02 * s.halfThickness}};
	stretch(sections, {tip, 0.5 * s.halfWidth, 0.5 * s.halfThickness}, 4);
	stretch(sections, {3 * tip, s.halfWidth, s.halfThickness}, 4);
	stretch(sections, {s.blade, s.halfWidth, s.halfThickness}, 24);
	stretch(sections, {s.blade, s.guardHalfWidth, s.guardHalfThickness}, 2);
	stretch(sections, {guard, s.guardHalfWidth, s.guardHalfThickness}, 2);
	stretch(sections, {guard, s.gripHalfWidth, s.gripHalfWidth}, 2);
	stretch(sections, {grip, s.gripHalfWidth, s.gripHalfWidth}, 10);
	stretch(sections, {grip + 0.5 * s.pommelHeight, s.pommelHalfWidth, s.pommelHalfWidth}, 3);
	stretch(sections, {end, s.gripHalfWidth, s.gripHalfWidth}, 3);
	return loft(sections, 4);
}
}  // namespace scenes
