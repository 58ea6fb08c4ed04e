// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "tests/unit/Core/Query/QueryBodies.h"

#include <random>
#include <vector>

// Two clouds of ellipsoids with levels, and poses of one in the frame of the other.
namespace ist
{
inline InnerSphereTree levelledCloud(int count, unsigned seed, const Vec3& origin = {})
{
	InnerSphereTree body = cloudBody(count, seed, origin);
	body.box = {{-1, -1, -1}, {1, 1, 1}};
	body.meanGap = 0.01;
	addLevels(body);
	return body;
}

inline const InnerSphereTree& bodyA()
{
	static const InnerSphereTree body = levelledCloud(6000, 1, {1000, -3, 2});
	return body;
}

inline const InnerSphereTree& bodyB()
{
	static const InnerSphereTree body = levelledCloud(3000, 2);
	return body;
}

/// Random rotations, from deep contact to barely touching.
inline std::vector<Pose> poses()
{
	std::mt19937 random(5);
	std::normal_distribution<double> gauss;
	std::vector<Pose> poses;
	for (int i = 0; i < 24; ++i)
	{
		const Vec3 turn{gauss(random), gauss(random), gauss(random)}, direction = normalized({gauss(random), gauss(random), gauss(random)});
		poses.push_back({rotationMatrix(quaternionFromRotationVector(turn)), bodyA().origin + (0.4 + 0.1 * i) * direction});
	}
	return poses;
}
}  // namespace ist
