// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "LinearMath/btTransform.h"

// Conversions between Bullet's types and ours, which are double in both precisions of Bullet. Not installed.

inline ist::Vec3 toVec3(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }
inline btVector3 toBullet(const ist::Vec3& v) { return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)); }

inline btMatrix3x3 toBullet(const ist::Mat3& a)
{
	btMatrix3x3 r;
	for (int i = 0; i < 3; ++i) r[i] = toBullet(ist::Vec3{a.m[i][0], a.m[i][1], a.m[i][2]});
	return r;
}

inline ist::Pose toPose(const btTransform& t)
{
	ist::Pose X;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) X.rotation.m[i][j] = double(t.getBasis()[i][j]);
	X.translation = toVec3(t.getOrigin());
	return X;
}

/// Pose of a body or shape. Games rotate bodies by products of matrices, and engines pass matrices of their own. Axes that have drifted
/// up to 5 % from unit length and right angles are corrected. Beyond that the pose is returned as it is, and is not rigid.
inline ist::Pose toRigidPose(const btTransform& t)
{
	ist::Pose X = toPose(t);
	if (isRigid(X, 1e-5) || !isRigid(X, 0.1)) return X;
	X.rotation = rotationMatrix(quaternion(X.rotation));
	return X;
}

inline btTransform toTransform(const ist::Pose& X)
{
	const ist::Quaternion q = quaternion(X.rotation);
	return btTransform(btQuaternion(btScalar(q.x), btScalar(q.y), btScalar(q.z), btScalar(q.w)), toBullet(X.translation));
}
