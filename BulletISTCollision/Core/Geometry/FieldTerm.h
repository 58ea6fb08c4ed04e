// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SymmetricMatrix3.h"

#include <cstdint>

namespace ist
{
/// Contribution of one fragment of a leaf to the overlap with an analytic field. Axes of A's mesh frame, relative to A's origin.
struct FieldTerm
{
	uint32_t ball = 0;      ///< index of the ball of A
	double volume = 0;      ///< shared volume, multiplied by the leaf's density [m^3]
	double depth = 0;       ///< mean depth of the shared part in the field [m]
	Vec3 centroid;          ///< centroid of the shared part
	Vec3 normal;            ///< mean of the field's normals over the shared part
	Vec3 area;              ///< gradient of the volume, pointing out of the field [m^2]
	SymmetricMatrix3 bend;  ///< derivative of `volume * normal` by position in the field: its curvature, edges included [m^2]
};
}  // namespace ist
