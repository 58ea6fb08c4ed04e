// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Leaves/Cells.h"

#include <algorithm>
#include <cstddef>

namespace ist
{
/// A point of a cell with the depth and outward normal of the body there, and the volume it represents. Members are not initialised:
/// there are millions of samples, and the threads that write them should be the first to touch their memory.
struct CellSample
{
	float x, y, z;
	float nx, ny, nz;
	float depth;
	float weight;  ///< volume that the point represents [m^3]
	Vec3 position() const { return {x, y, z}; }
	Vec3 normal() const { return {nx, ny, nz}; }
};

/// A cell or a part of one, with its samples [begin, end).
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

/// The stored form of a piece.
MomentEllipsoid momentEllipsoid(const CellPiece& piece);

/// Priority for splitting a piece: its volume times its size, increased if normals differ inside it. Also used for levels.
inline double splitPriority(double volume, double meanRadius, const Vec3& normal)
{
	constexpr double kCompactness = 0.1;  // source: bench_truth, whose errors hardly differ from 0.05 to 0.15
	return volume * meanRadius * (kCompactness + std::max(0.0, 1 - squaredNorm(normal)));
}

/// Splits cells into two by two-means clustering of position and normal. The cell with the largest splitPriority is split first, until
/// there are `leafCount` pieces or none can be split. Reorders the samples inside each cell. The pieces are grouped by cell, in the order
/// of `cells`. The result does not depend on the number of threads.
std::vector<CellPiece> splitCells(CellSample* samples, const std::vector<CellPiece>& cells, size_t leafCount, int threads = 1);
}  // namespace ist
