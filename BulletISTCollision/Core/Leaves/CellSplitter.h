// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Leaves/Cells.h"

#include <algorithm>
#include <cstddef>

namespace ist
{
/// A point of a cell with the depth and outward normal of the body there, and the volume it stands for. Nothing is set at first:
/// there are millions of them, and the threads that write them are the first to touch their memory.
struct CellSample
{
	float x, y, z;
	float nx, ny, nz;
	float depth;
	float weight;  ///< [m^3]
	Vec3 position() const { return {x, y, z}; }
	Vec3 normal() const { return {nx, ny, nz}; }
};

/// A cell or a part of one, with the samples [begin, end) that lie in it.
struct CellPiece
{
	size_t begin = 0, end = 0;
	uint32_t sphere = 0;
	double mass = 0;  ///< volume [m^3]
	Vec3 centroid;
	SymmetricMatrix3 shape;  ///< five times the covariance [m^2]
	Vec3 normal;
	double depth = 0;
	double meanRadius() const { return std::sqrt(shape.trace() / 3); }
};

/// The stored form.
MomentEllipsoid momentEllipsoid(const CellPiece& piece);

/// What splitting a piece is worth: its volume times its size, more where normals differ inside of it. For levels, too.
inline double splitPriority(double volume, double meanRadius, const Vec3& normal)
{
	constexpr double kCompactness = 0.1;  // of bench_truth's errors; from .05 to .15 they hardly differ
	return volume * meanRadius * (kCompactness + std::max(0.0, 1 - squaredNorm(normal)));
}

/// Splits cells by two means of place and normal, the one with the largest splitPriority first, until there are `leafCount` of
/// them or none can be split. Reorders the samples inside each cell. The pieces come grouped by cell, in the order of `cells`;
/// the same for any thread count.
std::vector<CellPiece> splitCells(CellSample* samples, const std::vector<CellPiece>& cells, size_t leafCount, int threads = 1);
}  // namespace ist
