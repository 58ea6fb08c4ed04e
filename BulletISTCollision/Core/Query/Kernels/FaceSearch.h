// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/QueryTables.h"

#include <cstdint>

// Interface between collectFaces and its kernels; only plain structs and raw pointers, as in QueryKernel.h.
namespace ist::kernels
{
/// Number of elements that are treated together, whatever the number of lanes.
constexpr int kFaceBatch = 16;
/// Errors up to which two surfaces are taken as flush.
constexpr float kFlushErrors = 2;
/// No point of a body lies farther from the center of its cell than this many of the cell's radii; the farthest seen was 7.8. Only cells
/// with a larger error per radius are held to it: the others are exact, or have hardly a sample.
constexpr float kFarthestRadii = 10, kLeastErrorOfRadius = 1e-3f;
/// Share of a flush face that counts as cut: whether it is inside is not known, and neighbours err alike.
constexpr float kFlushCut = 1.6f;
/// Least mean depth of a face as a share of its largest depth; a depth that falls to zero like a square has 1/6. A face with less was cut
/// so roughly that depths outside cancel those inside. Its area counts less, so that none vanishes at once when they cancel wholly.
constexpr float kLeastMean = 0.125f;

/// Elements, or quarters of elements, that may lie inside the body of a field. All is in the field's frame.
struct FaceBatch
{
	/// The frame and the depth as a quadratic function of the coordinates (s, t), for `cut`, and then the sums of faces, for `faces`, which
	/// have the edges E1 and E2, too.
	enum Column
	{
		Center,
		E1 = 3,
		E2 = 6,
		Normal = 9,
		Unit = 12,  ///< normal at unit length
		K11 = 15,
		K12,
		K22,
		SignedArea,    ///< negative for a triangle
		Depth,         ///< of ElementQuadratic: c, cs, ct, css, cst, ctt
		Flush = 25,    ///< surfaces that are nearer than this lie in each other, as far as their errors tell [m]
		Gradient,      ///< mean gradient of the depth; the columns up to here are those of the frame
		NormalS = 29,  ///< derivatives of the normal
		NormalT = 32,
		FaceCenter = 35,
		AreaNormal = 38,
		Pressure = 41,
		PressureCenter = 44,
		SpreadS = 47,  ///< integral of (x - center) (s - mean of s) dS
		SpreadT = 50,
		Area = 53,
		DepthIntegral,
		CutArea,
		ColumnCount
	};
	alignas(64) float column[ColumnCount][kFaceBatch];
	alignas(64) uint32_t element[kFaceBatch], cell[kFaceBatch];
	uint32_t quarter[kFaceBatch];  ///< number of the quarter, of batches of quarters
	bool isOfQuarters;
	uint32_t faces;   ///< bit k: element k is a face
	uint32_t cut;     ///< bit k: element k must be cut where the depth is zero
	uint32_t planes;  ///< bit k: element k, or its quarter, must be cut at the planes of the partition
};

/// The tables of a field (QueryTables), and its cells.
struct FieldTables
{
	const PlaneTriple* planes;
	const PartRef* starts;
	const DepthCell* cells;
	float lower[3], voxelsPerLength[3];  ///< of the grid of `starts`
	int32_t size[3];
};

/// Points in the field's frame, and the depth at each; zero where the body is not. Whole vectors are read and written: kListSlack entries
/// (QueryKernel.h) behind the end.
struct DepthPoints
{
	const float *x, *y, *z;
	float* depth;
	int count;
};

/// Finds the elements of a surface that may lie inside the body of a field.
struct FaceSearch : FieldTables
{
	const SurfaceQuad* quads;
	const SurfaceElement* elements;
	float domainLower[3], domainUpper[3];
	float margin, rounding, largest;  ///< margin of the domain; depth that counts as rounding; largest radius of elements that are sampled
	float rotation[9], translation[3];  ///< pose of the surface's frame in the field's
	/// Receives a batch with a bit set.
	void (*take)(void* context, const FaceBatch& batch);
	/// Receives an element that must be cut at the domain and at the planes of the partition.
	void (*takeUncut)(void* context, uint32_t element);
	void* context;
	int64_t nodes, sampled, quarters;  ///< counts of work
	int64_t dropped;                   ///< nodes that did not fit on the stack
	bool stop;                         ///< set by the receivers when enough faces are found
};
}  // namespace ist::kernels
