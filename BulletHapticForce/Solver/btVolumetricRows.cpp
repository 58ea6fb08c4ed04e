// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btVolumetricRows.h"

#include "BulletHapticForce/Solver/btToEigen.h"
#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <algorithm>
#include <cmath>
#include <utility>

using namespace btToEigen;

namespace
{
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Mat63 = Eigen::Matrix<double, 6, 3>;
using Eigen::Map;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// An eigenvalue below this share of the largest one belongs to a direction in which nothing can move.
constexpr double kImmovable = 1e-12;

bool canMove(const btVolumetricRowBody& body)
{
	double size = std::fabs(body.inverseMass.x) + std::fabs(body.inverseMass.y) + std::fabs(body.inverseMass.z);
	for (const auto& row : body.inverseInertia.m)
		for (const double x : row) size += std::fabs(x);
	return !(size <= 0);
}

/// Adds the response of one body: the twist at `point` to a unit impulse there.
void addResponse(Mat6& W, const btVolumetricRowBody& body, const ist::Vec3& point)
{
	if (!canMove(body)) return;
	const Vector3d r = toEigen(point - body.center);
	const Matrix3d X = crossMatrix(r), inertia = toEigen(body.inverseInertia);
	const Matrix3d turning = X * inertia;
	W.topLeftCorner<3, 3>() += turning * X.transpose();
	W.topLeftCorner<3, 3>().diagonal() += toEigen(body.inverseMass);
	W.topRightCorner<3, 3>() -= turning;
	W.bottomLeftCorner<3, 3>() += inertia * X;
	W.bottomRightCorner<3, 3>() += inertia;
}

constexpr int kRight = 10;  // number of right-hand sides
using Equations = double[6][6 + kRight];

/// Gaussian elimination with partial pivoting: replaces B by A^-1 B in the last columns of the six rows (A | B).
void eliminate(Equations& rows)
{
	for (int k = 0; k < 6; ++k)
	{
		int best = k;
		for (int i = k + 1; i < 6; ++i)
			if (std::fabs(rows[i][k]) > std::fabs(rows[best][k])) best = i;
		if (best != k) std::swap(rows[k], rows[best]);
		// Whole rows are processed from a copy, so that the compiler vectorises the loop. That is faster than skipping the few known
		// zeros.
		double pivot[6 + kRight];
		std::copy(rows[k], rows[k] + 6 + kRight, pivot);
		const double inverse = 1 / pivot[k];
		for (int i = k + 1; i < 6; ++i)
		{
			const double factor = rows[i][k] * inverse;
			for (int j = 0; j < 6 + kRight; ++j) rows[i][j] -= factor * pivot[j];
		}
	}
	for (int k = 5; k >= 0; --k)
	{
		const double inverse = 1 / rows[k][k];
		double found[kRight];
		for (int j = 0; j < kRight; ++j) rows[k][6 + j] = found[j] = rows[k][6 + j] * inverse;
		for (int i = 0; i < k; ++i)
		{
			const double factor = rows[i][k];
			for (int j = 0; j < kRight; ++j) rows[i][6 + j] -= factor * found[j];
		}
	}
}
}  // namespace

void btVolumetricRow::prepare(
	const btContactPatch& patch, const btVolumetricRowBody& A, const btVolumetricRowBody& B, double h, double friction)
{
	Mat6 both = Mat6::Zero();
	addResponse(both, A, patch.point);
	addResponse(both, B, patch.point);
	ist::SymmetricMatrix6 response;
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) response(i, j) = both(i, j);
	prepare(patch, response, h, friction);
}

void btVolumetricRow::prepare(const btContactPatch& patch, const ist::SymmetricMatrix6& response, double h, double friction)
{
	m_point = patch.point;
	m_normal = patch.normal;
	m_friction = friction;
	Map<Mat6> W(m_W);
	W = toEigen(response);
	const Mat6 S = h * h * toEigen(patch.stiffness) + h * toEigen(patch.damping);
	ist::Vec3 t1, t2;
	ist::completeFrame(patch.normal, t1, t2);
	Map<Mat63> E(m_E);
	E.setZero();
	E.col(0).head<3>() = toEigen(t1);
	E.col(1).head<3>() = toEigen(t2);
	E.col(2).tail<3>() = patch.frictionRadius * toEigen(patch.normal);

	Vec6 push;
	push << h * toEigen(patch.wrench.force), h * toEigen(patch.wrench.torque);
	Equations equations;
	using Rows = Eigen::Matrix<double, 6, 6 + kRight, Eigen::RowMajor>;
	Map<Rows> rows(&equations[0][0]);
	rows.leftCols<6>() = Mat6::Identity() + S * W;
	rows.middleCols<6>(6) = S;
	rows.col(12) = push;
	rows.rightCols<3>() = E;
	eliminate(equations);
	Map<Mat6> C(m_C);
	C = rows.middleCols<6>(6);
	Map<Vec6> alone(m_push);
	alone = rows.col(12);
	const Mat63 eased = rows.rightCols<3>();
	if (friction > 0) prepareFriction(eased.data());
	Map<Vec6>(m_elastic).setZero();
	Map<Vector3d>(m_tangent).setZero();
}

/// `eased` is (I + S W)^-1 E.
void btVolumetricRow::prepareFriction(const double* eased)
{
	const Map<const Mat63> E(m_E), easedE(eased);
	Map<Mat63> WE(m_WE), CWE(m_CWE);
	Map<Matrix3d> EWE(m_EWE);
	WE = Map<const Mat6>(m_W) * E;
	CWE = E - easedE;
	EWE = E.transpose() * WE;
	const Matrix3d response = WE.transpose() * easedE;
	double symmetric[3][3];
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) symmetric[i][j] = 0.5 * (response(i, j) + response(j, i));
	Map<Matrix3d> stick(m_stick);
	stick.setZero();
	m_slide = 0;
	ist::SymmetricEigen<3> eigen;
	if (!eigen.decompose(symmetric)) return;
	const double largest = std::max({eigen.values[0], eigen.values[1], eigen.values[2]});
	if (!(largest > 0)) return;
	m_slide = 1 / largest;
	for (int i = 0; i < 3; ++i)
	{
		if (!(eigen.values[i] > kImmovable * largest)) continue;
		const Map<const Vector3d> axis(eigen.vectors[i]);
		stick += axis * (axis.transpose() / eigen.values[i]);
	}
}

ist::Wrench btVolumetricRow::solve(const ist::Twist& relative)
{
	const Map<const Mat6> W(m_W), C(m_C);
	const Map<const Mat63> E(m_E), WE(m_WE), CWE(m_CWE);
	const Vector3d n = toEigen(m_normal);
	Map<Vec6> elastic(m_elastic);
	Map<Vector3d> tangent(m_tangent);
	const auto normalPart = [&] { return n.dot(elastic.head<3>()); };
	const auto answer = [&](const Vec6& impulse) {
		elastic = impulse;
		if (!(normalPart() > 0)) elastic.setZero();
	};

	Vec6 before = elastic, without;
	if (m_friction > 0) before += E * tangent;
	without << toEigen(relative.linear), toEigen(relative.angular);
	without -= W * before;
	const Vec6 alone = Map<const Vec6>(m_push) - C * without;
	if (!(m_friction > 0))
	{
		answer(alone);
		const Vec6 change = elastic - before;
		return {{change(0), change(1), change(2)}, {change(3), change(4), change(5)}};
	}
	answer(alone - CWE * tangent);
	const double limit = m_friction * normalPart();
	if (limit > 0)
	{
		const Vector3d slip = E.transpose() * without + WE.transpose() * elastic + Map<const Matrix3d>(m_EWE) * tangent;
		Vector3d wanted = tangent - Map<const Matrix3d>(m_stick) * slip;
		// Sliding friction acts along the slip itself. Scaling `wanted` back would turn the force towards the directions that move
		// easily.
		if (wanted.norm() > limit) wanted = tangent - m_slide * slip;
		tangent = wanted.norm() > limit ? Vector3d(wanted * (limit / wanted.norm())) : wanted;
		answer(alone - CWE * tangent);
	}
	const double finalLimit = m_friction * normalPart();
	if (tangent.norm() > finalLimit) tangent *= finalLimit / tangent.norm();

	const Vec6 change = elastic + E * tangent - before;
	return {{change(0), change(1), change(2)}, {change(3), change(4), change(5)}};
}

double btVolumetricRow::borne(const ist::Twist& twist) const
{
	Vec6 w;
	w << toEigen(twist.linear), toEigen(twist.angular);
	return w.dot(Map<const Mat6>(m_C) * w);
}

ist::Wrench btVolumetricRow::impulse() const
{
	const Vec6 total = Map<const Vec6>(m_elastic) + Map<const Mat63>(m_E) * Map<const Vector3d>(m_tangent);
	return {{total(0), total(1), total(2)}, {total(3), total(4), total(5)}};
}

ist::Wrench btVolumetricRow::elasticImpulse() const
{
	return {{m_elastic[0], m_elastic[1], m_elastic[2]}, {m_elastic[3], m_elastic[4], m_elastic[5]}};
}

double btVolumetricRow::normalImpulse() const { return Map<const Vec6>(m_elastic).head<3>().dot(toEigen(m_normal)); }
