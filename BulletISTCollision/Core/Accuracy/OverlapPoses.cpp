// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/OverlapPoses.h"

#include <algorithm>

namespace ist
{
namespace
{
constexpr int kHalvings = 30;

Vec3 randomDirection(std::mt19937_64& random)
{
	std::normal_distribution<double> normal;
	const double x = normal(random), y = normal(random), z = normal(random);
	return normalized({x, y, z});
}
}  // namespace

Departure randomDeparture(std::mt19937_64& random)
{
	const Vec3 axis = randomDirection(random), direction = randomDirection(random);
	const double angle = std::uniform_real_distribution<double>(0, 3.14159265358979)(random);
	return {rotationMatrix(quaternionFromRotationVector(angle * axis)), direction};
}

std::optional<Pose> poseAtOverlap(
	const InnerSphereTree& A, const InnerSphereTree& B, double fraction, int level, const Departure& departure, QueryWorkspace& workspace)
{
	const Mat3& R = departure.rotation;
	const auto apart = [&](double distance) { return Pose{R, A.origin - R * B.origin + distance * departure.direction}; };
	QueryOptions options;
	options.level = level;
	options.stiffness = options.patches = false;
	const double wanted = fraction * std::min(A.volume, B.volume);
	const auto overlaps = [&](double distance) { return queryOverlap(A, B, apart(distance), workspace, options).total.volume >= wanted; };
	double near = 0, far = norm(A.box.upper - A.box.lower) + norm(B.box.upper - B.box.lower);
	if (!overlaps(near)) return std::nullopt;
	for (int i = 0; i < kHalvings; ++i)
	{
		const double middle = 0.5 * (near + far);
		(overlaps(middle) ? near : far) = middle;
	}
	return apart(near);
}

std::optional<Pose> poseAtOverlap(
	const InnerSphereTree& A, const InnerSphereTree& B, double fraction, int level, std::mt19937_64& random, QueryWorkspace& workspace)
{
	return poseAtOverlap(A, B, fraction, level, randomDeparture(random), workspace);
}
}  // namespace ist
