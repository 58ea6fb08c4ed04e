// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/SpherePacking.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "BulletISTCollision/Core/Surface/BodySurface.h"
#include "BulletISTCollision/Core/Tree/BallTree.h"

#include <algorithm>
#include <string>
#include <vector>

namespace ist
{
/// A body that is ready for queries: its trees, its mass properties and its provenance. Immutable once built or loaded; share it by
/// `std::shared_ptr<const InnerSphereTree>`.
///
/// There are two frames. The *mesh frame* is that of the source file, after unit scaling. The *tree frame* has the same axes and its
/// origin at `origin` (the mesh's centre of mass), so that floats stay accurate however far the mesh lies from its origin. All stored
/// coordinates are in the tree frame; all public queries take poses of mesh frames.
struct InnerSphereTree
{
	Vec3 origin;                     ///< origin of the tree frame, in the mesh frame [m]
	double volume = 0;               ///< volume of the repaired mesh [m^3]
	Mat3 inertia = zeroMat3();       ///< about the centre of mass, density 1 [m^5]
	double area = 0;                 ///< surface area of the repaired mesh [m^2]
	Box box;                         ///< bounding box of the repaired mesh, tree frame
	double meanGap = 0, maxGap = 0;  ///< see Cells.h [m]
	double uncoveredArea = 0;
	double fill = 0;
	double resolution = 0;  ///< surfaceResolution() of `law` [m]
	double sagitta = 0;     ///< facetSagitta() of the repaired mesh [m]

	FrozenArray<Sphere> spheres;      ///< the packing, largest first
	BodySurface surface;              ///< what contact with trees, half-spaces and boxes is computed from; may be empty
	BallTree law;                     ///< leaves: contact with curved closed forms, at coarser levels, and where a body has no surface
	std::vector<BallTree> levels;     ///< coarser versions of `law`, the finest first (TreeLevels.h); may be empty
	std::vector<double> calibration;  ///< calibration of the leaves and of each level (LevelCalibration.h); empty if never measured
	BallTree cells;                   ///< unsplit cells: volume mode
	BallTree inner;                   ///< packed spheres: distance, lower bound, paper mode

	/// The origin of the tree: source mesh and build settings.
	struct Provenance
	{
		uint64_t meshHash = 0;
		double unit = 1;                  ///< metres per unit of the source file
		double meshVolume = 0;            ///< volume of the mesh as read [m^3]
		bool watertight = false;          ///< whether the mesh was closed as read
		std::string repairMode;           ///< "auto", "off", "wrap", or groundText()
		std::vector<std::string> repair;  ///< actions of the repair
		int64_t requestedSpheres = 0;
		double requestedFill = 1, requestedMinRadius = 0;
		uint64_t seed = 1;
	} provenance;

	/// Error length g of the body for the error bar of a query (PressureField.h) [m]. Leaves blur the surface even of a body without
	/// gaps.
	double errorLength() const { return (std::max)(meanGap, resolution); }

	/// Empty if every invariant holds (those of each tree, finite values, positive volume); otherwise the first violation.
	std::string validate() const;
};
}  // namespace ist
