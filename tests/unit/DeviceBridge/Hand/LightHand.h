// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeCache.h"
#include "DeviceBridge/Hand/HandModel.h"
#include "DeviceBridge/Hand/HandPosture.h"

#include <memory>
#include <random>

/// A model of a hand for tests that need no good trees. It has the palm's own tree and one tree for all bones, which takes 1 s instead of
/// 16 s.
inline std::shared_ptr<const devicebridge::HandModel> lightHand(const std::string& folder, bool left = false)
{
	using namespace devicebridge;
	auto model = std::make_shared<HandModel>();
	model->shape = measureHand(posedHand({}, {left, 0.189})).value();
	ist::BuildOptions options;
	options.maxSpheres = 60;
	std::shared_ptr<const ist::InnerSphereTree> bone;
	for (int i = 0; i < kHandParts; ++i)
	{
		HandModel::Part& part = model->parts[static_cast<std::size_t>(i)];
		part.mesh = handPartMesh(model->shape, i == kHandPart ? i : int(kMiddle3));
		part.centre = massProperties(part.mesh).centerOfMass;
		part.mesh = translated(part.mesh, -part.centre);
		if (i <= 1) part.tree = ist::cachedTree(part.mesh, options, folder).value().tree;
		if (i == 1) bone = part.tree;
		if (i > 1) part.tree = bone;
	}
	return model;
}

/// A random posture that a hand can take, anywhere.
inline devicebridge::HandPosture randomPosture(std::mt19937& random)
{
	std::uniform_real_distribution<double> bend(0, 1.2), any(-1, 1);
	devicebridge::HandPosture p;
	for (devicebridge::FingerPosture* finger : {&p.index, &p.middle, &p.ring, &p.little})
		*finger = {bend(random), bend(random), bend(random), 0.1 * any(random)};
	p.thumb = {bend(random), 0.5 * bend(random), 3 * any(random), bend(random), bend(random)};
	p.X_WR = {rotationMatrix(ist::quaternionFromRotationVector({2 * any(random), 2 * any(random), any(random)})),
		{any(random), 1000 * any(random), any(random)}};
	return p;
}
