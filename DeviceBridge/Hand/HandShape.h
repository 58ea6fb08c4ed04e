// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "DeviceBridge/Hand/HandParts.h"

#include <array>

namespace devicebridge
{
/// Dimensions from which the meshes of a hand's parts are made: lengths and thicknesses [m].
struct HandShape
{
	struct Bone
	{
		double length = 0, radius = 0, endRadius = 0;
	};
	struct Palm
	{
		ist::Vec3 wrist;        ///< position of the wrist in the palm's joint frame; all positions here are those of a right hand
		ist::Vec3 knuckles[4];  ///< positions of index, middle, ring and little finger
		double knuckleRadii[4] = {};
		double wristRadius = 0;
	};

	bool left = false;
	std::array<Bone, kHandParts> bones;  ///< bones by part; the palm's entry is unused
	Palm palm;
};

/// Measures a hand with all joints tracked, in any posture. Neighbouring fingers are made thinner where they would overlap in the straight
/// hand. Refused, with the joint's number: a joint that is not tracked or not finite, a palm with an invalid rotation, a bone or radius of
/// length zero.
ist::Result<HandShape> measureHand(const HandState& hand);

/// The closed surface of a part in its joint frame (handPartJoint). A bone is a round cone, slightly flat, with a waist; its ends extend
/// beyond its joints by their radii. The palm is a slab with rounded edges from the wrist to the knuckles. Meshes of a left hand are mirror
/// images.
ist::Mesh handPartMesh(const HandShape& shape, int part);
}  // namespace devicebridge
