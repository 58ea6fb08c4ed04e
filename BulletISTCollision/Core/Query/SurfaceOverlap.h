// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Faces/ContactFaces.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Surface/BodySurface.h"

#include <memory>

namespace ist::kernels
{
struct QueryKernel;
}  // namespace ist::kernels

namespace ist
{
/// All memory of surfaceOverlap. Use one per thread, and reuse it.
class SurfaceWorkspace
{
public:
	/// `faces`: capacity of each of the two lists of faces.
	explicit SurfaceWorkspace(size_t faces = 32768, int patches = 8, const kernels::QueryKernel* kernel = nullptr);
	~SurfaceWorkspace();
	/// Makes all memory resident: 40 MB with the default capacity.
	void makeResident();

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};

/// Result of surfaceOverlap. Faces, normals and moments have the axes of A's tree frame and are relative to its origin.
struct SurfaceOverlap
{
	OverlapIntegrals total;
	const OverlapIntegrals* patches = nullptr;  ///< in the workspace, valid until its next use; they sum to `total`
	int patchCount = 0;
	const ContactFace *ofA = nullptr, *ofB = nullptr;  ///< faces of A inside B, and of B inside A
	size_t countA = 0, countB = 0;
	double leanOnA = 0, leanOnB = 0;  ///< OverlapResult::leanOnA
	size_t dropped = 0;               ///< faces that did not fit into the workspace and are missing from the sums
	bool isOverLimit = false;         ///< there are more faces than `mostFaces`: there are no sums
	FaceCounts counts;
};

/// Overlap of two bodies from their surfaces. X_AB: pose of B's tree frame in A's. With q the depth and n the outward normal of a body,
/// Gauss's theorem turns the integrals of the contact law into integrals over the surfaces (docs/model.md):
///   Int n_A dV = - Int_(surface of B inside A) q_A n_B dS, and the same with x x n.
/// `mostFaces`: limit at which the search ends; negative: none. Cost: O(faces). No allocation.
SurfaceOverlap surfaceOverlap(const BodySurface& A, const BodySurface& B, const Pose& X_AB, SurfaceWorkspace& workspace,
	const DampingWeights& damping = {}, int mostPatches = 1024, int64_t mostFaces = -1);
}  // namespace ist
