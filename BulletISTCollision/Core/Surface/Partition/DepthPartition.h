// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/ConvexRegion.h"
#include "BulletISTCollision/Core/Surface/DepthField.h"
#include "BulletISTCollision/Core/Surface/Partition/ClippedSurface.h"
#include "BulletISTCollision/Core/Surface/Partition/QuadricFit.h"

#include <cstddef>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

namespace ist
{
struct DepthPartitionOptions
{
	size_t cells = 1;    ///< largest number of cells
	double spacing = 0;  ///< typical size of a cell [m]
	double size = 0;     ///< longest side of the body [m]
	uint64_t seed = 1;
	int threads = 1;
};

/// Splits the domain top-down, the node with the largest residual first, until the field is exact or there are enough cells.
/// Deterministic for a seed, for any number of threads.
class DepthPartition
{
public:
	/// Keeps a reference to the mesh.
	DepthPartition(const Mesh& mesh, std::vector<DepthSample> samples, const DepthPartitionOptions& options);

	/// Splits what can be split, up to `most` cells. `goesOn` gets the share of the cells that exist; the result is false if it returned
	/// false.
	bool split(size_t most, const std::function<bool(double)>& goesOn);

	/// Adds those of the samples that the field does not match, and fits their cells again. Returns their number.
	size_t addMisfits(const std::vector<DepthSample>& samples);

	/// Adds points of the surface in every cell that the field does not match, in the same way.
	size_t addMisfitsOfSurface();

	/// Adds points outside of the body where a cell's depth is positive, in the same way. Looks in every cell, however thin, so that none
	/// reaches out of the body between the samples. `stream`: each gives other points.
	size_t addMisfitsOutside(const MeshDistance& surface, const Box& domain, uint64_t stream);

	size_t cellCount() const { return m_parts.size(); }
	bool isFull() const { return m_parts.size() >= m_options.cells; }
	DepthField field(const Box& domain) const;

private:
	/// A node with a cell, and the samples and the surface in it.
	struct Part
	{
		std::vector<DepthSample> samples;
		ClippedSurface surface;
		size_t node = 0;
		double priority = 0;
		QuadricFit fit;
	};
	struct Halves
	{
		DepthNode node;
		Part first, second;
		bool isSplit = false;
	};
	using Waiting = std::pair<double, size_t>;  // priority, part
	struct Before
	{
		bool operator()(const Waiting& a, const Waiting& b) const { return a.first != b.first ? a.first < b.first : a.second > b.second; }
	};

	size_t partAt(const Vec3& x) const;
	void cornersOf(size_t node, ConvexRegion region, std::vector<std::vector<Vec3>>& corners) const;
	bool isMisfit(size_t part, const DepthSample& sample) const;
	bool takeBatch(size_t most, std::vector<size_t>& batch);
	void fit(Part& part) const;
	Part partOf(std::vector<DepthSample> samples, ClippedSurface surface) const;
	Halves halvesOf(Part& parent) const;
	void add(size_t parent, Halves& halves);
	std::vector<DepthSample> misfitsOfSurface(size_t part) const;
	size_t addToParts(const std::function<std::vector<DepthSample>(size_t part)>& misfitsOf);
	double deepestOf(const Part& part, bool holdsSurface) const;
	double heightOf(const Part& part, const Vec3& up) const;
	void cutOffOutside(std::vector<DepthNode>& nodes) const;

	const Mesh& m_mesh;
	const double m_tolerance;  // of the surface
	DepthPartitionOptions m_options;
	std::vector<DepthNode> m_nodes;  // the cell of a node is the index of its part
	std::vector<Part> m_parts;
	std::priority_queue<Waiting, std::vector<Waiting>, Before> m_queue;
};
}  // namespace ist
