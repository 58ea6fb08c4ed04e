// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshShells.h"

#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Mesh/MeshEdges.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
constexpr std::size_t kNestingProbes = 16;
/// Depths below the surface at which a shell is asked whether it fills a cavity, as shares of its longest side.
constexpr double kCavityDepths[] = {1e-3, 0.05, 0.25};
/// Share of the area times the longest side; a shell with less volume encloses nothing.
constexpr double kFlatShell = 1e-9;

/// Tolerances relative to the outer shell's longest side and to the mesh's rounding. A probe this near to the outer surface lies on it,
/// and its winding number is not reliable.
constexpr double kOnSurface = 1e-6, kRoundedApart = 2;

/// A closed component.
struct Shell
{
	std::vector<uint32_t> triangles;
	Box box;
	double volume = 0;  ///< signed, as given [m^3]
	double area = 0;
	int sign = 1;  ///< sign of the volume, as decided
	bool kept = true;
	std::vector<uint32_t> around;           ///< the shells that enclose this one
	std::unique_ptr<MeshDistance> surface;  ///< built if another shell may lie inside
};

/// The lowest triangle index of each triangle's shell. Triangles are connected through edges of two triangles, and through other edges if
/// the sides do not balance by themselves.
std::vector<uint32_t> shellOfTriangle(const Mesh& mesh)
{
	const std::vector<EdgeUse> edges = sortedEdges(mesh);
	TriangleSets sets(mesh.triangles.size());
	forEachEdge(edges, [&](const EdgeUse* use, std::size_t count) {
		if (count == 2) sets.unite(use[0].triangle, use[1].triangle);
	});
	for (bool united = true; united;)
	{
		united = false;
		forEachEdge(edges, [&](const EdgeUse* use, std::size_t count) {
			if (count <= 2) return;
			const auto balance = [&](uint32_t set) {
				int64_t sum = 0;
				for (std::size_t i = 0; i < count; ++i)
					if (sets.find(use[i].triangle) == set) sum += use[i].forward ? 1 : -1;
				return sum;
			};
			for (std::size_t i = 0; i + 1 < count; ++i)
			{
				const uint32_t set = sets.find(use[i].triangle);
				if (balance(set) == 0) continue;
				for (std::size_t j = i + 1; j < count && balance(sets.find(use[i].triangle)) != 0; ++j)
				{
					const uint32_t other = sets.find(use[j].triangle);
					if (other == sets.find(use[i].triangle) || balance(other) == 0) continue;
					sets.unite(use[i].triangle, use[j].triangle);
					united = true;
				}
			}
		});
	}
	std::vector<uint32_t> shell(mesh.triangles.size());
	for (std::size_t i = 0; i < shell.size(); ++i) shell[i] = sets.find(static_cast<uint32_t>(i));
	return shell;
}

std::vector<Shell> shells(const Mesh& mesh)
{
	const std::vector<uint32_t> component = shellOfTriangle(mesh);
	std::vector<Shell> result;
	std::vector<uint32_t> shellOf(mesh.triangles.size());
	for (uint32_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const Triangle& t = mesh.triangles[i];
		if (component[i] == i)
		{
			shellOf[i] = static_cast<uint32_t>(result.size());
			result.emplace_back().box = {mesh.vertices[t[0]], mesh.vertices[t[0]]};
		}
		Shell& shell = result[shellOf[component[i]]];
		shell.triangles.push_back(i);
		for (const uint32_t corner : t)
		{
			shell.box.lower = componentMin(shell.box.lower, mesh.vertices[corner]);
			shell.box.upper = componentMax(shell.box.upper, mesh.vertices[corner]);
		}
		const Vec3 origin = mesh.vertices[mesh.triangles[shell.triangles[0]][0]];
		const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin, c = mesh.vertices[t[2]] - origin;
		shell.volume += dot(a, cross(b, c)) / 6;
		shell.area += 0.5 * norm(cross(b - a, c - a));
	}
	for (Shell& shell : result)
	{
		shell.sign = shell.volume < 0 ? -1 : 1;
		shell.kept = std::fabs(shell.volume) > kFlatShell * shell.area * shell.box.longestSide();
	}
	return result;
}

bool encloses(const Box& outer, const Box& inner, double slack)
{
	for (int axis = 0; axis < 3; ++axis)
		if (inner.lower[axis] < outer.lower[axis] - slack || inner.upper[axis] > outer.upper[axis] + slack) return false;
	return true;
}

bool overlap(const Box& a, const Box& b)
{
	for (int axis = 0; axis < 3; ++axis)
		if (a.lower[axis] >= b.upper[axis] || b.lower[axis] >= a.upper[axis]) return false;
	return true;
}

Mesh meshOf(const Mesh& mesh, const Shell& shell)
{
	Mesh part;
	for (const uint32_t i : shell.triangles)
	{
		const auto base = static_cast<uint32_t>(part.vertices.size());
		for (const uint32_t corner : mesh.triangles[i]) part.vertices.push_back(mesh.vertices[corner]);
		part.triangles.push_back({base, base + 1, base + 2});
	}
	return part;
}

/// Every probe that is not on the outer surface must lie inside, and there must be at least one: shells that only cut each other are not
/// nested. `rounding`: rounding of the mesh [m].
bool encloses(const Mesh& mesh, double rounding, Shell& outer, const Shell& inner)
{
	const double onSurface = std::max(kOnSurface * outer.box.longestSide(), kRoundedApart * rounding);
	if (!encloses(outer.box, inner.box, onSurface) || std::fabs(outer.volume) <= std::fabs(inner.volume)) return false;
	if (!outer.surface) outer.surface = std::make_unique<MeshDistance>(meshOf(mesh, outer));
	const std::size_t stride = std::max<std::size_t>(1, inner.triangles.size() / kNestingProbes);
	bool found = false;
	for (std::size_t i = 0; i < inner.triangles.size(); i += stride)
	{
		const Triangle& t = mesh.triangles[inner.triangles[i]];
		const Vec3 probe = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
		if (outer.surface->closest(probe, onSurface).triangle != UINT32_MAX) continue;
		if (std::fabs(outer.surface->windingNumber(probe)) < 0.5) return false;
		found = true;
	}
	return found;
}

/// The box of all shells that are kept.
Box boundsOfKept(const std::vector<Shell>& all)
{
	Box box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
	for (const Shell& shell : all)
		if (shell.kept) box = {componentMin(box.lower, shell.box.lower), componentMax(box.upper, shell.box.upper)};
	return box;
}

/// Sweeps along the longest side, so that a pair is met once: when both have begun and neither has ended. Across a thin layer each shell
/// would meet all others.
void findNesting(const Mesh& mesh, std::vector<Shell>& all, ShellVerdict& verdict)
{
	const int axis = boundsOfKept(all).longestAxis();
	const double rounding = mesh.rounding * bounds(mesh).longestSide();
	std::vector<uint32_t> order, active;
	for (uint32_t i = 0; i < all.size(); ++i)
		if (all[i].kept) order.push_back(i);
	std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
		const double begin = all[a].box.lower[axis], other = all[b].box.lower[axis];
		return begin != other ? begin < other : a < b;
	});
	for (const uint32_t k : order)
	{
		Shell& shell = all[k];
		std::erase_if(active, [&](uint32_t i) { return all[i].box.upper[axis] < shell.box.lower[axis]; });
		verdict.compared += static_cast<int64_t>(active.size());
		for (const uint32_t i : active)
		{
			if (encloses(mesh, rounding, all[i], shell)) shell.around.push_back(i);
			else if (encloses(mesh, rounding, shell, all[i])) all[i].around.push_back(k);
			else verdict.mayOverlap = verdict.mayOverlap || overlap(all[i].box, shell.box);
		}
		active.push_back(k);
	}
}

/// Whether solid material of the other shells is missing somewhere in a shell that lies in an outer one: it fills a cavity, at least in
/// part. Points below its triangles are looked at, so that a shell that touches the wall of the cavity is found, too.
bool fillsCavity(const Mesh& mesh, std::vector<Shell>& all, uint32_t index)
{
	Shell& shell = all[index];
	// Shells in this one, or deeper in others, do not decide what it is.
	const auto decides = [&](const Shell& other) { return &other != &shell && other.kept && other.around.size() <= shell.around.size(); };
	const auto isCavity = [&](const Shell& other) { return decides(other) && other.sign < 0 && overlap(other.box, shell.box); };
	if (std::none_of(all.begin(), all.end(), isCavity)) return false;
	const auto contains = [&](Shell& outer, const Vec3& p) {
		if (!outer.surface) outer.surface = std::make_unique<MeshDistance>(meshOf(mesh, outer));
		return std::fabs(outer.surface->windingNumber(p)) > 0.5;
	};
	const std::size_t stride = std::max<std::size_t>(1, shell.triangles.size() / kNestingProbes);
	for (std::size_t i = 0; i < shell.triangles.size(); i += stride)
	{
		const Triangle& t = mesh.triangles[shell.triangles[i]];
		const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
		const Vec3 outward = (shell.volume < 0 ? -1 : 1) * normalized(cross(b - a, c - a));
		for (const double depth : kCavityDepths)
		{
			const Vec3 probe = (a + b + c) / 3 - depth * shell.box.longestSide() * outward;
			if (!contains(shell, probe)) continue;
			int64_t winding = 0;
			for (Shell& other : all)
				if (decides(other) && encloses(other.box, {probe, probe}, 0) && contains(other, probe)) winding += other.sign;
			if (winding <= 0) return true;
		}
	}
	return false;
}

void decide(const Mesh& mesh, std::vector<Shell>& all, ShellVerdict& verdict)
{
	std::vector<uint32_t> order;
	for (uint32_t i = 0; i < all.size(); ++i)
		if (all[i].kept) order.push_back(i);
		else ++verdict.dropped;
	std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return all[a].around.size() < all[b].around.size(); });
	// A shell in an outermost shell that faces inwards is inside out with it.
	for (const uint32_t i : order)
		for (const uint32_t j : all[i].around)
			if (all[j].around.empty() && all[j].volume < 0) all[i].sign = all[i].volume < 0 ? 1 : -1;
	for (const uint32_t i : order)
	{
		int64_t winding = 0;
		for (const uint32_t j : all[i].around) winding += all[j].sign;
		if (winding <= 0) all[i].sign = 1;
		else if (winding + all[i].sign > 0 && !(all[i].sign > 0 && fillsCavity(mesh, all, i)))
		{
			all[i].kept = false;
			++verdict.redundant;
		}
	}
}
}  // namespace

ShellVerdict settleShells(Mesh& mesh)
{
	std::vector<Shell> all = shells(mesh);
	ShellVerdict verdict;
	findNesting(mesh, all, verdict);
	decide(mesh, all, verdict);
	std::vector<uint8_t> keep(mesh.triangles.size(), 1);
	for (const Shell& shell : all)
	{
		const bool turn = shell.kept && (shell.volume < 0) != (shell.sign < 0);
		verdict.turned += turn;
		for (const uint32_t i : shell.triangles)
		{
			if (turn) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
			keep[i] = shell.kept;
		}
	}
	std::size_t kept = 0;
	for (std::size_t i = 0; i < keep.size(); ++i)
		if (keep[i]) mesh.triangles[kept++] = mesh.triangles[i];
	mesh.triangles.resize(kept);
	return verdict;
}
}  // namespace ist
