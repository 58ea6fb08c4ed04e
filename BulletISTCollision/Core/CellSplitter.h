// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Cells.h"

#include <cstddef>

namespace ist
{
/// A point of a cell with the depth and outward normal of the body there, and the volume it stands for.
struct CellSample
{
	float x = 0, y = 0, z = 0;
	float nx = 0, ny = 0, nz = 0;
	float depth = 0;
	float weight = 0;  ///< [m^3]
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

/// Splits cells into compact pieces, the one with the largest mass * mean radius * (0.15 + 1 - |normal|^2) first, until there are `leafCount` of
/// them or none can be split. Reorders the samples inside each cell. The pieces come grouped by cell, in the order of `cells`;
/// the same for any thread count.
std::vector<CellPiece> splitCells(std::vector<CellSample>& samples, const std::vector<CellPiece>& cells, size_t leafCount, int threads = 1);
}  // namespace ist
