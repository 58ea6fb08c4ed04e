// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshProbes.h"

#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace ist
{
namespace
{
// Offset of a point in its cell, so that no plane of points lies in a face of a mesh with round coordinates.
constexpr double kShift = 0.3819660112501051;
/// Distance from an integer winding number that small holes and cracks cause.
constexpr double kNearlyWhole = 0.25;

/// Calls visit(point) for each grid point and returns the volume of a cell.
template <class Visitor> double forEachProbe(const Mesh& mesh, int cells, Visitor visit)
{
	const Box box = bounds(mesh);
	const double step = box.longestSide() / cells;
	if (!(step > 0)) return 0;
	// Points are counted, because very far from the origin a step may be smaller than the coordinates can represent.
	const auto count = [&](int axis) { return int(std::ceil((box.upper[axis] - box.lower[axis]) / step - kShift)); };
	const auto at = [&](int axis, int i) { return box.lower[axis] + (i + kShift) * step; };
	for (int k = 0; k < count(2); ++k)
		for (int j = 0; j < count(1); ++j)
			for (int i = 0; i < count(0); ++i) visit(Vec3{at(0, i), at(1, j), at(2, k)});
	return step * step * step;
}
}  // namespace

double miscountedShare(const Mesh& mesh, int cells)
{
	const MeshDistance surface(mesh);
	int64_t inside = 0;
	double wrong = 0;
	forEachProbe(mesh, cells, [&](const Vec3& p) {
		const double winding = std::round(surface.windingNumber(p));
		inside += winding > 0;
		wrong += std::fabs(winding - (winding > 0));
	});
	return inside > 0 ? wrong / static_cast<double>(inside) : std::numeric_limits<double>::infinity();
}

double contradictedShare(const Mesh& open, const Mesh& closed, int cells)
{
	const MeshDistance before(open), after(closed);
	int64_t inside = 0, contradicted = 0;
	forEachProbe(open, cells, [&](const Vec3& p) {
		const double was = before.windingNumber(p), is = after.windingNumber(p);
		inside += std::fabs(was) > 0.5 || std::fabs(is) > 0.5;
		contradicted += std::fabs(was - std::round(was)) < kNearlyWhole && std::round(was) != std::round(is);
	});
	return inside > 0 ? static_cast<double>(contradicted) / static_cast<double>(inside) : 0;
}

double ambiguousVolume(const Mesh& open, int cells)
{
	const MeshDistance surface(open);
	double sum = 0;
	const double cell = forEachProbe(open, cells, [&](const Vec3& p) {
		const double winding = surface.windingNumber(p);
		sum += std::fabs(winding - (winding > 0.5));
	});
	return sum * cell;
}

bool enclosesInsideOut(const Mesh& mesh, int cells)
{
	const MeshDistance surface(mesh);
	bool found = false;
	forEachProbe(mesh, cells, [&](const Vec3& p) { found = found || surface.windingNumber(p) < kNearlyWhole - 1; });
	return found;
}
}  // namespace ist
