// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "DeviceBridge/Hand/HandParts.h"

#include <array>

namespace devicebridge
{
/// What the meshes of a hand's parts are made from: lengths and thicknesses [m].
struct HandShape
{
	struct Bone
	{
		double length = 0, radius = 0, endRadius = 0;
	};
	struct Palm
	{
		ist::Vec3 wrist;        ///< in the palm's joint frame of a right hand, as all here
		ist::Vec3 knuckles[4];  ///< of index, middle, ring and little finger
		double knuckleRadii[4] = {};
		double wristRadius = 0;
	};

	bool left = false;
	std::array<Bone, kHandParts> bones;  ///< that of the palm says nothing
	Palm palm;
};

/// The shape of a hand that all of whose joints are tracked, in any posture. Neighbouring fingers are made thinner where they would overlap
/// in the straight hand. Refused, with the joint's number: one that is not tracked or not finite, a palm whose orientation is no rotation,
/// a bone or a radius of no length.
ist::Result<HandShape> measureHand(const HandState& hand);

/// The closed surface of a part in its joint frame (handPartJoint). A bone is a round cone, a little flat, with a waist; its ends reach
/// over its joints by their radii. The palm is a slab with rounded edges from the wrist to the knuckles. Meshes of a left hand are mirror
/// images.
ist::Mesh handPartMesh(const HandShape& shape, int part);
}  // namespace devicebridge
