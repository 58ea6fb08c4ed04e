// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/QueryTables.h"

#include "BulletISTCollision/Core/Surface/ConvexRegion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
/// Few, because each voxel repeats the planes of the others above it. With twenty times as many, queries are no faster.
constexpr double kVoxelsPerCell = 0.1;
/// The part of a voxel is that of a box which is larger by this share of it on each side, because queries round.
constexpr double kVoxelGrowth = 1e-3;
/// Planes that enter a voxel by less than this share of its edge are left out.
constexpr double kSlack = 1e-5;

using Voxel = std::array<int, 3>;

/// Whether the depth of the cell is negative in all of a region.
bool isNegative(const DepthCell& cell, const ConvexRegion& region)
{
	double largest = -1e300, reach = 0, bend = 0;
	const Vec3 center = region.center();
	for (const auto& face : region.faces())
		for (const Vec3& x : face)
		{
			largest = std::max(largest, cell.at(x).depth);
			reach = std::max(reach, norm(x - center));
		}
	for (int i = 0; i < 6; ++i) bend += (i < 3 ? 1 : 2) * double(cell.hessian[i]) * cell.hessian[i];
	// Between points at a distance of d, a function rises above their values by at most its second derivative times d^2 / 8.
	return largest + 0.5 * std::sqrt(bend) * reach * reach < 0;
}

/// Builds the table of planes.
class PartitionTable
{
public:
	PartitionTable(const DepthField& field, QueryTables& tables) : m_field(field), m_tables(tables) {}

	void build()
	{
		m_planes.push_back({});
		layGrid();
		fill(0, {0, 0, 0}, {m_tables.size[0], m_tables.size[1], m_tables.size[2]});
		m_tables.planes = std::move(m_planes);
		m_tables.starts = std::move(m_starts);
	}

private:
	void layGrid()
	{
		const Vec3 sides = m_field.domain.size();
		const double edge = std::cbrt(sides.x * sides.y * sides.z / (kVoxelsPerCell * double(m_field.cells.size())));
		size_t count = 1;
		for (int i = 0; i < 3; ++i)
		{
			m_tables.size[i] = std::max(1, int(std::lround(sides[i] / edge)));
			m_tables.lower[i] = float(m_field.domain.lower[i]);
			m_tables.voxelsPerLength[i] = float(m_tables.size[i] / sides[i]);
			count *= size_t(m_tables.size[i]);
		}
		m_starts.resize(count);
		m_slack = kSlack * edge;
	}

	/// Fills the voxels [from, to), whose box lies in the node.
	void fill(uint32_t node, const Voxel& from, const Voxel& to)
	{
		Box box;
		size_t axis = 0;
		for (size_t i = 0; i < 3; ++i)
		{
			const double lower = m_tables.lower[i], perLength = m_tables.voxelsPerLength[i];
			box.lower[int(i)] = lower + (from[i] - kVoxelGrowth) / perLength;
			box.upper[int(i)] = lower + (to[i] + kVoxelGrowth) / perLength;
			if (to[i] - from[i] > to[axis] - from[axis]) axis = i;
		}
		const ConvexRegion region(box);
		node = firstCrossing(node, region);
		if (to[axis] - from[axis] > 1 && !m_field.nodes[node].isCell())
		{
			Voxel middleTo = to, middleFrom = from;
			middleTo[axis] = middleFrom[axis] = (from[axis] + to[axis]) / 2;
			fill(node, from, middleTo);
			fill(node, middleFrom, to);
			return;
		}
		const PartRef part = partOf(node, region);
		for (int x = from[0]; x < to[0]; ++x)
			for (int y = from[1]; y < to[1]; ++y)
				for (int z = from[2]; z < to[2]; ++z) m_starts[size_t((x * m_tables.size[1] + y) * m_tables.size[2] + z)] = part;
	}

	/// The first node below `at` whose plane crosses the region, or a node without children.
	uint32_t firstCrossing(uint32_t at, const ConvexRegion& region) const
	{
		for (;;)
		{
			const DepthNode& node = m_field.nodes[at];
			if (node.isCell()) return at;
			const auto [low, high] = region.rangeOf(node);
			if (low > -m_slack || high <= m_slack)
			{
				at = node.child + (low + high > 0 ? 1 : 0);
				continue;
			}
			if (!m_field.nodes[node.child + 1].isOutside()) return at;
			// The plane is needed only where the cell below it is positive above it.
			ConvexRegion above = region;
			above.clip(node, 1);
			if (!isNegative(m_field.cells[m_field.nodes[node.child].cell()], above)) return at;
			at = node.child;
		}
	}

	/// The part of the partition below a node, without planes that do not cross the region.
	PartRef partOf(uint32_t at, const ConvexRegion& region)
	{
		at = firstCrossing(at, region);
		const DepthNode& node = m_field.nodes[at];
		if (node.isCell()) return leafAt(at);
		const size_t index = m_planes.size();
		m_planes.push_back({});
		PlaneTriple triple{};
		putPlane(node, triple.plane[0]);
		for (int side = 0; side < 2; ++side)
		{
			ConvexRegion half = region;
			half.clip(node, side);
			const uint32_t childAt = firstCrossing(node.child + uint32_t(side), half);
			const DepthNode& child = m_field.nodes[childAt];
			if (!child.isCell()) putPlane(child, triple.plane[1 + side]);
			for (int j = 0; j < 2; ++j)
			{
				PartRef& ref = triple.child[2 * side + j];
				if (child.isCell())
				{
					ref = leafAt(childAt);
					continue;
				}
				ConvexRegion quarter = half;
				quarter.clip(child, j);
				ref = partOf(child.child + uint32_t(j), quarter);
			}
		}
		m_planes[index] = triple;
		return PartRef(index);
	}

	PartRef leafAt(uint32_t at) const
	{
		const DepthNode& node = m_field.nodes[at];
		// The cell below a node outside says best how far away the body is.
		const uint32_t cell = m_field.nodes[node.isOutside() ? at - 1 : at].cell();
		return ~(2 * int32_t(cell) + (node.deepest < 0 ? kOutsideFlag : 0));
	}

	static void putPlane(const DepthNode& node, float (&plane)[4])
	{
		for (int i = 0; i < 3; ++i) plane[i] = node.normal[i];
		plane[3] = node.offset;
	}

	const DepthField& m_field;
	QueryTables& m_tables;
	std::vector<PlaneTriple> m_planes;
	std::vector<PartRef> m_starts;
	double m_slack = 0;
};

/// Merges nodes of a surface into nodes with four children: the largest children are replaced by their own.
std::vector<SurfaceQuad> quadsOf(const ContactSurface& surface)
{
	struct Waiting
	{
		uint32_t node;
		size_t quad;
	};
	std::vector<SurfaceQuad> quads(1);
	std::vector<Waiting> waiting = {{0, 0}};
	while (!waiting.empty())
	{
		const auto [root, at] = waiting.back();
		waiting.pop_back();
		std::vector<uint32_t> children = {root};
		while (children.size() < 4)
		{
			const auto opens = [&](uint32_t node) { return surface.nodes[node].isElement() ? -1.0f : surface.nodes[node].radius; };
			const auto largest = std::max_element(
				children.begin(), children.end(), [&](uint32_t a, uint32_t b) { return opens(a) < opens(b); });
			if (surface.nodes[*largest].isElement()) break;
			const uint32_t first = surface.nodes[*largest].child;
			*largest = first;
			children.push_back(first + 1);
		}
		SurfaceQuad quad{};
		std::fill(std::begin(quad.radius), std::end(quad.radius), -1.0f);
		for (size_t i = 0; i < children.size(); ++i)
		{
			const SurfaceNode& node = surface.nodes[children[i]];
			quad.x[i] = node.center[0];
			quad.y[i] = node.center[1];
			quad.z[i] = node.center[2];
			quad.radius[i] = node.radius;
			quad.child[i] = node.child;
			if (node.isElement()) continue;
			quad.child[i] = uint32_t(quads.size());
			waiting.push_back({children[i], quads.size()});
			quads.push_back({});
		}
		quads[at] = quad;
	}
	return quads;
}

float medianOfCells(const DepthField& field, float DepthCell::*member)
{
	std::vector<float> values;
	for (const DepthCell& cell : field.cells) values.push_back(cell.*member);
	const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
	std::nth_element(values.begin(), middle, values.end());
	return *middle;
}
}  // namespace

QueryTables buildQueryTables(const ContactSurface& surface, const DepthField& field)
{
	QueryTables tables;
	tables.quads = quadsOf(surface);
	tables.cellRadius = medianOfCells(field, &DepthCell::radius);
	tables.typicalError = std::max(float(surface.error()), medianOfCells(field, &DepthCell::error));
	for (const SurfaceElement& e : surface.elements) tables.error = std::max(tables.error, e.error);
	for (const DepthCell& c : field.cells) tables.error = std::max(tables.error, c.error);
	PartitionTable(field, tables).build();
	return tables;
}
}  // namespace ist
