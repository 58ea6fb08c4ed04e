// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"

namespace ist
{
/// A 3x3 matrix, row major.
struct Mat3
{
	double m[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

	Vec3 row(int i) const { return {m[i][0], m[i][1], m[i][2]}; }
	Vec3 column(int j) const { return {m[0][j], m[1][j], m[2][j]}; }
};

inline Mat3 zeroMat3() { return {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}; }

inline Vec3 operator*(const Mat3& a, const Vec3& v) { return {dot(a.row(0), v), dot(a.row(1), v), dot(a.row(2), v)}; }
inline Mat3 operator*(const Mat3& a, const Mat3& b)
{
	Mat3 c;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) c.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j];
	return c;
}
inline Mat3 transpose(const Mat3& a)
{
	return {{{a.m[0][0], a.m[1][0], a.m[2][0]}, {a.m[0][1], a.m[1][1], a.m[2][1]}, {a.m[0][2], a.m[1][2], a.m[2][2]}}};
}

/// A quaternion, scalar last (the order of the command line and of Bullet).
struct Quaternion
{
	double x = 0, y = 0, z = 0, w = 1;
};

/// Rotation matrix of a unit quaternion.
inline Mat3 rotationMatrix(const Quaternion& q)
{
	const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
	const double xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
	const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
	return {{{1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)}, {2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx)},
		{2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)}}};
}

/// Unit quaternion, w >= 0, of a rotation matrix (Shepperd's method: the largest component first).
inline Quaternion quaternion(const Mat3& r)
{
	const double trace = r.m[0][0] + r.m[1][1] + r.m[2][2];
	Quaternion q;
	if (trace > 0)
	{
		const double s = 2 * std::sqrt(1 + trace);
		q = {(r.m[2][1] - r.m[1][2]) / s, (r.m[0][2] - r.m[2][0]) / s, (r.m[1][0] - r.m[0][1]) / s, s / 4};
	}
	else
	{
		const int i = r.m[0][0] > r.m[1][1] ? (r.m[0][0] > r.m[2][2] ? 0 : 2) : (r.m[1][1] > r.m[2][2] ? 1 : 2);
		const int j = (i + 1) % 3, k = (i + 2) % 3;
		const double s = 2 * std::sqrt(1 + r.m[i][i] - r.m[j][j] - r.m[k][k]);
		double v[3];
		v[i] = s / 4;
		v[j] = (r.m[j][i] + r.m[i][j]) / s;
		v[k] = (r.m[k][i] + r.m[i][k]) / s;
		q = {v[0], v[1], v[2], (r.m[k][j] - r.m[j][k]) / s};
	}
	const double n = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w) * (q.w < 0 ? -1 : 1);
	return {q.x / n, q.y / n, q.z / n, q.w / n};
}

/// Rotation by |v| radians about v (exponential map).
inline Quaternion quaternionFromRotationVector(const Vec3& v)
{
	const double angle = norm(v);
	const double s = angle > 1e-8 ? std::sin(angle / 2) / angle : 0.5 - angle * angle / 48;
	return {v.x * s, v.y * s, v.z * s, std::cos(angle / 2)};
}

/// Rotation vector of a unit quaternion, length in [0, pi] (logarithmic map).
inline Vec3 rotationVector(const Quaternion& q)
{
	const double sign = q.w < 0 ? -1 : 1;
	const Vec3 v{q.x * sign, q.y * sign, q.z * sign};
	const double s = norm(v);
	return s > 1e-12 ? v * (2 * std::atan2(s, q.w * sign) / s) : v * 2.0;
}

inline Quaternion operator*(const Quaternion& a, const Quaternion& b)
{
	return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
		a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
inline Quaternion conjugate(const Quaternion& q) { return {-q.x, -q.y, -q.z, q.w}; }

/// Rigid transform. `X_WA` is the pose of frame A in frame W: p_W = X_WA * p_A.
struct Pose
{
	Mat3 rotation;
	Vec3 translation;
};

inline Vec3 operator*(const Pose& X, const Vec3& p) { return X.rotation * p + X.translation; }
inline Pose operator*(const Pose& X_AB, const Pose& X_BC) { return {X_AB.rotation * X_BC.rotation, X_AB * X_BC.translation}; }
inline Pose inverse(const Pose& X)
{
	const Mat3 r = transpose(X.rotation);
	return {r, -(r * X.translation)};
}

/// True when every entry is finite and |R R^T - I| <= tolerance in every entry, with a positive determinant.
inline bool isRigid(const Pose& X, double tolerance = 1e-4)
{
	if (!isFinite(X.translation)) return false;
	const Mat3 e = X.rotation * transpose(X.rotation);
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
			if (!(std::fabs(e.m[i][j] - (i == j ? 1 : 0)) <= tolerance)) return false;
	return dot(X.rotation.row(0), cross(X.rotation.row(1), X.rotation.row(2))) > 0;
}

/// Force and torque [N, N m], or any pair (resultant, moment about a stated point).
struct Wrench
{
	Vec3 force, torque;
};
inline Wrench operator+(const Wrench& a, const Wrench& b) { return {a.force + b.force, a.torque + b.torque}; }
inline Wrench operator-(const Wrench& a, const Wrench& b) { return {a.force - b.force, a.torque - b.torque}; }
inline Wrench operator*(double s, const Wrench& a) { return {s * a.force, s * a.torque}; }
inline bool isFinite(const Wrench& w) { return isFinite(w.force) && isFinite(w.torque); }

/// Linear velocity of a stated point and angular velocity [m/s, rad/s].
struct Twist
{
	Vec3 linear, angular;
};
inline Twist operator+(const Twist& a, const Twist& b) { return {a.linear + b.linear, a.angular + b.angular}; }
inline Twist operator-(const Twist& a, const Twist& b) { return {a.linear - b.linear, a.angular - b.angular}; }
inline bool isFinite(const Twist& t) { return isFinite(t.linear) && isFinite(t.angular); }
}  // namespace ist
