// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandModel.h"

#include "BulletISTCollision/Core/Build/TreeCache.h"

#include <cmath>

using namespace ist;

namespace devicebridge
{
Result<std::shared_ptr<const HandModel>> buildHandModel(const HandShape& shape, const HandBuildOptions& options)
{
	auto model = std::make_shared<HandModel>();
	model->shape = shape;
	BuildOptions build;
	build.maxSpheres = options.spheres;
	build.threads = options.threads;
	build.progress = options.progress;
	for (int i = 0; i < kHandParts; ++i)
	{
		HandModel::Part& part = model->parts[static_cast<std::size_t>(i)];
		part.mesh = handPartMesh(shape, i);
		part.centre = massProperties(part.mesh).centerOfMass;
		part.mesh = translated(part.mesh, -part.centre);
		Result<CachedTree> tree = cachedTree(part.mesh, build, options.cache);
		if (!tree) return Error{handPartName(i, shape.left) + ": " + tree.error().message, tree.error().cancelled};
		part.tree = tree.value().tree;
	}
	return std::shared_ptr<const HandModel>(std::move(model));
}

// Distance beyond which nothing counts as a hand [m], so that differences of positions and their squares stay finite.
constexpr double kFarthestHand = 1e9;

HandPartPoses handPartPoses(const HandModel& model, const HandState& hand) noexcept
{
	HandPartPoses poses;
	for (std::size_t i = 0; i < kHandParts; ++i)
	{
		const HandJoint& joint = hand.joints[static_cast<std::size_t>(handPartJoint(int(i)))];
		const Quaternion& q = joint.orientation;
		if (!joint.tracked || !(norm(joint.position) < kFarthestHand) || !isNearUnit(q)) continue;
		const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
		const Pose X_WJ{rotationMatrix({q.x / length, q.y / length, q.z / length, q.w / length}), joint.position};
		poses.X_WB[i] = {X_WJ.rotation, X_WJ * model.parts[i].centre};
		poses.known[i] = true;
	}
	return poses;
}
}  // namespace devicebridge
