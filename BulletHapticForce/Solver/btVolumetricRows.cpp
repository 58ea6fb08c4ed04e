// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btVolumetricRows.h"

#include "BulletHapticForce/Solver/btToEigen.h"
#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <algorithm>
#include <cmath>
#include <iterator>
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

template <int kRight> using Equations = double[6][6 + kRight];
template <int kRight> using Rows = Eigen::Matrix<double, 6, 6 + kRight, Eigen::RowMajor>;

/// Gaussian elimination with partial pivoting: replaces B by A^-1 B in the last columns of the six rows (A | B).
template <int kRight> void eliminate(Equations<kRight>& rows)
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
	const btContactPatch& patch, const btVolumetricRowBody& A, const btVolumetricRowBody& B, double h, const btContactFriction& friction)
{
	Mat6 both = Mat6::Zero();
	addResponse(both, A, patch.point);
	addResponse(both, B, patch.point);
	ist::SymmetricMatrix6 response;
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) response(i, j) = both(i, j);
	prepare(patch, response, h, friction);
}

void btVolumetricRow::prepare(
	const btContactPatch& patch, const ist::SymmetricMatrix6& response, double h, const btContactFriction& friction)
{
	m_point = patch.point;
	m_normal = patch.normal;
	Map<Mat6> W(m_W);
	W = toEigen(response);
	const Mat6 S = h * h * toEigen(patch.stiffness) + h * toEigen(patch.damping);
	const Mat6 stiffened = Mat6::Identity() + S * W;
	btFrictionBall balls[btContactFriction::kMostBalls];
	const int ballCount = friction.balls(patch, balls);

	Vec6 push;
	push << h * toEigen(patch.wrench.force), h * toEigen(patch.wrench.torque);
	Equations<10> equations;
	Map<Rows<10>> rows(&equations[0][0]);
	rows.leftCols<6>() = stiffened;
	rows.middleCols<6>(6) = S;
	rows.col(12) = push;
	rows.rightCols<3>() = Map<const Mat63>(balls[0].E);
	eliminate<10>(equations);
	Map<Mat6> C(m_C);
	C = rows.middleCols<6>(6);
	Map<Vec6> alone(m_push);
	alone = rows.col(12);
	Map<Vec6>(m_elastic).setZero();

	m_frictionCount = 0;
	Mat63 eased = rows.rightCols<3>();
	for (int i = 0; i < ballCount; ++i)
	{
		if (i > 0)
		{
			Equations<3> others;
			Map<Rows<3>>(&others[0][0]) << stiffened, Map<const Mat63>(balls[i].E);
			eliminate<3>(others);
			eased = Map<Rows<3>>(&others[0][0]).rightCols<3>();
		}
		addFriction(balls[i], eased.data());
	}
}

/// `eased` is (I + S W)^-1 E.
void btVolumetricRow::addFriction(const btFrictionBall& ball, const double* eased)
{
	Friction& f = m_frictions[m_frictionCount++];
	f.coefficient = ball.coefficient;
	std::copy(std::begin(ball.E), std::end(ball.E), f.E);
	Map<Vector3d>(f.tangent).setZero();
	const Map<const Mat63> E(f.E), easedE(eased);
	Map<Mat63> WE(f.WE), CWE(f.CWE);
	WE = Map<const Mat6>(m_W) * E;
	CWE = E - easedE;
	const Matrix3d response = WE.transpose() * easedE;
	double symmetric[3][3];
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) symmetric[i][j] = 0.5 * (response(i, j) + response(j, i));
	Map<Matrix3d> stick(f.stick);
	stick.setZero();
	f.slide = 0;
	ist::SymmetricEigen<3> eigen;
	if (!eigen.decompose(symmetric)) return;
	const double largest = std::max({eigen.values[0], eigen.values[1], eigen.values[2]});
	if (!(largest > 0)) return;
	f.slide = 1 / largest;
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
	const Vector3d n = toEigen(m_normal);
	Map<Vec6> elastic(m_elastic);
	const auto normalPart = [&] { return n.dot(elastic.head<3>()); };
	const auto frictionThrough = [this](Matrix63 Friction::*matrix) {
		Vec6 sum = Vec6::Zero();
		for (int i = 0; i < m_frictionCount; ++i)
			sum += Map<const Mat63>(m_frictions[i].*matrix) * Map<const Vector3d>(m_frictions[i].tangent);
		return sum;
	};

	const Vec6 before = elastic + frictionThrough(&Friction::E);
	Vec6 without;
	without << toEigen(relative.linear), toEigen(relative.angular);
	without -= W * before;
	const Vec6 alone = Map<const Vec6>(m_push) - C * without;
	const auto answer = [&] {
		elastic = alone - frictionThrough(&Friction::CWE);
		if (!(normalPart() > 0)) elastic.setZero();
	};
	answer();
	for (int i = 0; i < m_frictionCount; ++i)
	{
		Friction& f = m_frictions[i];
		Map<Vector3d> tangent(f.tangent);
		const double limit = f.coefficient * normalPart();
		if (!(limit > 0)) continue;
		const Vector3d slip = Map<const Mat63>(f.E).transpose() * without +
			Map<const Mat63>(f.WE).transpose() * (elastic + frictionThrough(&Friction::E));
		Vector3d wanted = tangent - Map<const Matrix3d>(f.stick) * slip;
		// Sliding friction acts along the slip itself. Scaling `wanted` back would turn the force towards the directions that move
		// easily.
		if (wanted.norm() > limit) wanted = tangent - f.slide * slip;
		tangent = wanted.norm() > limit ? Vector3d(wanted * (limit / wanted.norm())) : wanted;
		answer();
	}
	for (int i = 0; i < m_frictionCount; ++i)
	{
		Map<Vector3d> tangent(m_frictions[i].tangent);
		const double limit = m_frictions[i].coefficient * normalPart();
		if (tangent.norm() > limit) tangent *= limit / tangent.norm();
	}

	const Vec6 change = elastic + frictionThrough(&Friction::E) - before;
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
	Vec6 total = Map<const Vec6>(m_elastic);
	for (int i = 0; i < m_frictionCount; ++i) total += Map<const Mat63>(m_frictions[i].E) * Map<const Vector3d>(m_frictions[i].tangent);
	return {{total(0), total(1), total(2)}, {total(3), total(4), total(5)}};
}

ist::Wrench btVolumetricRow::elasticImpulse() const
{
	return {{m_elastic[0], m_elastic[1], m_elastic[2]}, {m_elastic[3], m_elastic[4], m_elastic[5]}};
}

double btVolumetricRow::normalImpulse() const { return Map<const Vec6>(m_elastic).head<3>().dot(toEigen(m_normal)); }
