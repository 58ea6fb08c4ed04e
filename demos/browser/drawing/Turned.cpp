// SPDX-License-Identifier: Zlib
#include "demos/browser/drawing/Turned.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
}

Mesh turned(const std::vector<std::pair<double, double>>& outline, int segments, double piece)
{
	std::vector<std::pair<double, double>> fine;
	for (size_t i = 0; i < outline.size(); ++i)
	{
		const auto &a = outline[i], &b = outline[(i + 1) % outline.size()];
		const int parts = std::max(1, int(std::ceil(std::hypot(b.first - a.first, b.second - a.second) / piece)));
		for (int k = 0; k < parts; ++k)
			fine.push_back({a.first + (b.first - a.first) * k / parts, a.second + (b.second - a.second) * k / parts});
	}
	Mesh mesh;
	const uint32_t n = uint32_t(fine.size()), m = uint32_t(segments);
	for (uint32_t s = 0; s < m; ++s)
		for (const auto& [r, y] : fine) mesh.vertices.push_back({r * std::cos(2 * kPi * s / m), y, r * std::sin(2 * kPi * s / m)});
	const auto at = [&](uint32_t s, uint32_t i) { return (s % m) * n + i % n; };
	for (uint32_t s = 0; s < m; ++s)
		for (uint32_t i = 0; i < n; ++i)
		{
			mesh.triangles.push_back({at(s, i), at(s, i + 1), at(s + 1, i + 1)});
			mesh.triangles.push_back({at(s, i), at(s + 1, i + 1), at(s + 1, i)});
		}
	return mesh;
}

Mesh gear(int teeth, double module, double halfWidth, double play)
{
	const double pressure = 20 * kPi / 180, pitch = 0.5 * module * teeth, base = pitch * std::cos(pressure), outer = pitch + module,
				 root = pitch - 1.25 * module;
	// Half of the angle of a tooth at a radius. The involute's polar angle grows by tan(a) - a.
	const auto involute = [&](double r) {
		const double a = std::acos(std::min(1.0, base / r));
		return std::tan(a) - a;
	};
	const double half = 0.5 * kPi / teeth - 0.5 * play / pitch;
	const auto halfAngle = [&](double r) { return half + involute(pitch) - involute(std::max(r, base)); };
	std::vector<std::pair<double, double>> flank;  // radius, half angle, from the root up
	constexpr int kSteps = 8;
	flank.push_back({root, halfAngle(root)});
	const double from = std::max(root, base);
	for (int i = root < base ? 0 : 1; i <= kSteps; ++i)
	{
		const double r = from + (outer - from) * i / kSteps;
		flank.push_back({r, halfAngle(r)});
	}
	std::vector<std::pair<double, double>> outline;  // radius, angle, counter-clockwise from above when z points down
	for (int t = 0; t < teeth; ++t)
	{
		const double middle = 2 * kPi * t / teeth;
		for (const auto& [r, a] : flank) outline.push_back({r, middle - a});
		for (size_t i = flank.size(); i-- > 0;) outline.push_back({flank[i].first, middle + flank[i].second});
	}
	Mesh mesh;
	constexpr uint32_t kLayers = 4;
	const uint32_t n = uint32_t(outline.size());
	for (uint32_t l = 0; l <= kLayers; ++l)
		for (const auto& [r, a] : outline) mesh.vertices.push_back({r * std::cos(a), halfWidth * (2.0 * l / kLayers - 1), r * std::sin(a)});
	const uint32_t below = uint32_t(mesh.vertices.size()), above = below + 1;
	mesh.vertices.push_back({0, -halfWidth, 0});
	mesh.vertices.push_back({0, halfWidth, 0});
	for (uint32_t i = 0; i < n; ++i)
	{
		const uint32_t next = (i + 1) % n;
		for (uint32_t l = 0; l < kLayers; ++l)
		{
			mesh.triangles.push_back({l * n + i, (l + 1) * n + i, (l + 1) * n + next});
			mesh.triangles.push_back({l * n + i, (l + 1) * n + next, l * n + next});
		}
		mesh.triangles.push_back({below, i, next});
		mesh.triangles.push_back({above, kLayers * n + next, kLayers * n + i});
	}
	return mesh;
}
}  // namespace browser
