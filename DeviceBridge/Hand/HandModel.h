// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "DeviceBridge/Hand/HandShape.h"

#include <memory>

namespace devicebridge
{
/// A hand ready for contact: sixteen meshes with their trees. It is immutable once built, so it can be shared.
struct HandModel
{
	struct Part
	{
		ist::Mesh mesh;  ///< mesh in the part's body frame, which is the joint frame moved to the centre of mass
		std::shared_ptr<const ist::InnerSphereTree> tree;
		ist::Vec3 centre;  ///< centre of mass, in the joint frame
	};
	HandShape shape;
	std::array<Part, kHandParts> parts;
};

struct HandBuildOptions
{
	int64_t spheres = 300;   ///< number of spheres per part
	std::string cache;       ///< folder for the trees (ist::cachedTree); empty: none
	int threads = 0;         ///< number of threads; 0: all
	ist::Progress progress;  ///< callback for the stages of each part in turn
};

/// Builds the model offline, in about 1 s of processor time per part with 300 spheres.
ist::Result<std::shared_ptr<const HandModel>> buildHandModel(const HandShape& shape, const HandBuildOptions& options);

/// Poses of the parts' body frames in World. `known` is false for a part whose joint is not tracked, not finite, or has an invalid
/// rotation.
struct HandPartPoses
{
	std::array<ist::Pose, kHandParts> X_WB;
	std::array<bool, kHandParts> known{};
};
HandPartPoses handPartPoses(const HandModel& model, const HandState& hand) noexcept;
}  // namespace devicebridge
