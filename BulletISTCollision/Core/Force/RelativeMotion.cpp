// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/RelativeMotion.h"

#include "BulletISTCollision/Core/Force/PressureField.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
double work(const Wrench& w, const Twist& t) { return dot(w.force, t.linear) + dot(w.torque, t.angular); }

/// Change of a wrench whose forces turn about the centre of the overlap. That centre is taken to stay fixed on A. In fact it moves by
/// half of the distance that B's surface moves there, which is small where the two touch.
Wrench turnedAbout(const Vec3& center, const Wrench& w, const Vec3& by)
{
	const Vec3 force = cross(by, w.force), rest = w.torque - cross(center, w.force);
	return {force, cross(center, force) + cross(by, rest)};
}

/// Change of a wrench along the normals of A, over which B slides: the force keeps its direction, and moves on with B.
Wrench slidOver(const Vec3& center, const Wrench& w, const Twist& motion)
{
	const double size = norm(w.force);
	if (!(size > 0)) return {};
	const Vec3 normal = w.force / size, way = motion.linear + cross(motion.angular, center);
	return {{}, cross(way - dot(way, normal) * normal, w.force)};
}

/// Change of a wrench that moves as a whole with the motion.
Wrench movedWith(const Twist& motion, const Wrench& w)
{
	return {cross(motion.angular, w.force), cross(motion.angular, w.torque) + cross(motion.linear, w.force)};
}
}  // namespace

Twist motionOfB(const Pose& X_before, const Pose& X_after, const Vec3& point)
{
	const Vec3 onB = transpose(X_before.rotation) * (point - X_before.translation);
	return {X_after * onB - point, rotationVector(quaternion(X_after.rotation * transpose(X_before.rotation)))};
}

double farthestMotion(const Pose& X_before, const Pose& X_after, const Vec3& center, double radius)
{
	double squares = 0;  // The Frobenius norm is never below the largest stretch.
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			const double difference = X_after.rotation.m[i][j] - X_before.rotation.m[i][j];
			squares += difference * difference;
		}
	return distance(X_before * center, X_after * center) + radius * std::sqrt(squares);
}

void moveB(OverlapIntegrals& sums, const Twist& motion)
{
	const Wrench ofA = sums.stiffnessA * motion, ofB = sums.stiffnessB * motion;
	sums.depthA += work(0.5 * ofA - sums.normalA, motion);
	sums.depthB += work(0.5 * ofB + sums.normalB, motion);
	const Vec3 centroid = sums.volume > 0 ? sums.firstMoment / sums.volume : Vec3();
	// The stiffness of curved surfaces is the symmetric part of a derivative whose other part follows from the wrench: half of what the
	// wrench changes by when it moves with B (docs/model.md, section 3). Where one slides over the other, forces keep its normals.
	const auto shareOf = [&](double volume) { return sums.volume > 0 ? volume / sums.volume : 0; };
	const double overA = shareOf(sums.slidingVolumeA), overB = shareOf(sums.slidingVolumeB), surface = shareOf(sums.surfaceVolume),
				 curved = surface - overA - overB;
	const auto change = [&](const Wrench& w) {
		return 0.5 * curved * movedWith(motion, w) + overA * slidOver(centroid, w, motion) +
			overB * turnedAbout(centroid, w, motion.angular);
	};
	const double formerA = norm(sums.normalA.force), formerB = norm(sums.normalB.force);
	sums.normalA = sums.normalA - ofA + change(sums.normalA);
	sums.normalB = sums.normalB + ofB + change(sums.normalB) + (1 - surface) * turnedAbout(centroid, sums.normalB, motion.angular);
	if (formerA > 0) sums.pressedA *= norm(sums.normalA.force) / formerA;
	if (formerB > 0) sums.pressedB *= norm(sums.normalB.force) / formerB;
	if (!(sums.volume > 0)) return;
	const Vec3 atCentroid = motion.linear + cross(motion.angular, centroid);
	const double growth = std::max(1 + dot(sums.areaVector, atCentroid) / sums.volume, 0.0);
	sums.volume *= growth;
	sums.firstMoment *= growth;
	for (double& m : sums.secondMoment) m *= growth;
	for (double& d : sums.damping.m) d *= growth;
}
}  // namespace ist
