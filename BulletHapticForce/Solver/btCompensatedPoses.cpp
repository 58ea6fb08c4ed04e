// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btCompensatedPoses.h"

#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
constexpr double kEpsilon = double(std::numeric_limits<btScalar>::epsilon());
/// Number of roundings in one of Bullet's steps, of positions and of the entries of rotations (quaternion from matrix, product, and
/// back).
constexpr double kRoundingsOfPosition = 2, kRoundingsOfRotation = 16;

/// Rotation vector of a rotation by less than 90 degrees; zero where both matrices are equal, bit by bit.
ist::Vec3 turn(const ist::Mat3& before, const ist::Mat3& now)
{
	const ist::Mat3 R = now * ist::transpose(before);
	const ist::Vec3 v = 0.5 * ist::Vec3{R.m[2][1] - R.m[1][2], R.m[0][2] - R.m[2][0], R.m[1][0] - R.m[0][1]};
	const double sine = norm(v);
	return sine > 0 ? std::asin(std::min(sine, 1.0)) / sine * v : v;
}

ist::Mat3 rotation(const ist::Vec3& vector) { return ist::rotationMatrix(ist::quaternionFromRotationVector(vector)); }

/// Computes what Bullet's step from `before` to `now` with velocity `v` has lost. Returns false when the body did not move by such a
/// step.
bool lostInStep(const ist::Pose& before, const ist::Pose& now, const ist::Twist& v, double h, ist::Twist& lost)
{
	// The order matters: the first difference is exact.
	lost.linear = before.translation - now.translation + h * v.linear;
	lost.angular = h * v.angular - turn(before.rotation, now.rotation);
	for (int i = 0; i < 3; ++i)
	{
		const double size = std::fabs(before.translation[i]) + std::fabs(h * v.linear[i]);
		if (!(std::fabs(lost.linear[i]) <= kRoundingsOfPosition * kEpsilon * size)) return false;
		if (!(std::fabs(lost.angular[i]) <= kRoundingsOfRotation * kEpsilon)) return false;
	}
	return true;
}
}  // namespace

void btCompensatedPoses::reserve(size_t bodies)
{
	if (bodies > m_places.size()) m_places.resize(std::max(bodies, 2 * m_places.size()));
}

btCompensatedPoses::Place* btCompensatedPoses::find(const btRigidBody& body)
{
	const int index = body.getWorldArrayIndex();
	if (index < 0) return nullptr;
	reserve(size_t(index) + 1);
	return &m_places[size_t(index)];
}

ist::Twist btCompensatedPoses::recall(const btRigidBody& body, uint64_t step)
{
	Place* place = find(body);
	if (!place) return {};
	if (place->body == &body && place->step == step) return place->lacking;
	ist::Twist lost;
	if (place->body == &body && place->step + 1 == step &&
		lostInStep(place->pose, toPose(body.getWorldTransform()), place->velocity, place->h, lost))
		place->lacking = {place->lacking.linear + lost.linear, place->lacking.angular + lost.angular};
	else place->lacking = {};
	place->body = &body;
	place->step = step;
	return place->lacking;
}

void btCompensatedPoses::takeBack(const btRigidBody& body, double time, double h, uint64_t step)
{
	Place* place = find(body);
	if (!place || place->body != &body || place->step != step) return;
	const ist::Twist motion = btISTBodyMotion().with({toVec3(body.getLinearVelocity()), toVec3(body.getAngularVelocity())}, h).twist;
	place->lacking = place->lacking - ist::Twist{time * motion.linear, time * motion.angular};
}

void btCompensatedPoses::settle(btRigidBody& body, double h, uint64_t step)
{
	Place* place = find(body);
	if (!place || place->body != &body || place->step != step) return;
	btTransform pose = body.getWorldTransform();
	const ist::Pose before = toPose(pose);
	pose.setOrigin(toBullet(before.translation + place->lacking.linear));
	if (norm(place->lacking.angular) > kEpsilon) pose.setBasis(toBullet(rotation(place->lacking.angular) * before.rotation));
	place->pose = toPose(pose);
	place->lacking.linear = place->lacking.linear - (place->pose.translation - before.translation);
	place->lacking.angular = place->lacking.angular - turn(before.rotation, place->pose.rotation);
	place->velocity = {toVec3(body.getLinearVelocity()), toVec3(body.getAngularVelocity())};
	place->h = h;
	body.setWorldTransform(pose);
}
