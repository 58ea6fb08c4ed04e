// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "DeviceBridge/Hand/HandShape.h"

#include <memory>

namespace devicebridge
{
/// A hand ready for contact: sixteen meshes with their trees. Immutable once built; share it.
struct HandModel
{
	struct Part
	{
		ist::Mesh mesh;  ///< in the part's body frame: the joint frame moved to the centre of mass
		std::shared_ptr<const ist::InnerSphereTree> tree;
		ist::Vec3 centre;  ///< of mass, in the joint frame
	};
	HandShape shape;
	std::array<Part, kHandParts> parts;
};

struct HandBuildOptions
{
	int64_t spheres = 300;   ///< a part
	std::string cache;       ///< folder for the trees (ist::cachedTree); empty: none
	int threads = 0;         ///< 0: all
	ist::Progress progress;  ///< stages of each part in turn
};

/// Offline; a second of processor time a part with 300 spheres.
ist::Result<std::shared_ptr<const HandModel>> buildHandModel(const HandShape& shape, const HandBuildOptions& options);

/// Where the parts' body frames are in World; of those whose joint is not tracked, not finite or no rotation, `known` is false.
struct HandPartPoses
{
	std::array<ist::Pose, kHandParts> X_WB;
	std::array<bool, kHandParts> known{};
};
HandPartPoses handPartPoses(const HandModel& model, const HandState& hand) noexcept;
}  // namespace devicebridge
