// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btVolumetricRows.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace
{
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using RowMat6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Mat63 = Eigen::Matrix<double, 6, 3>;
using MapVec6 = Eigen::Map<Vec6>;
using MapMat6 = Eigen::Map<RowMat6>;
using ConstVec6 = Eigen::Map<const Vec6>;
using ConstMat6 = Eigen::Map<const RowMat6>;
using ConstMat63 = Eigen::Map<const Mat63>;

// An eigenvalue below this share of the largest one belongs to a direction in which nothing can move.
constexpr double kImmovable = 1e-12;

Eigen::Vector3d toEigen(const ist::Vec3& v) { return {v.x, v.y, v.z}; }

Mat6 toEigen(const ist::SymmetricMatrix6& a)
{
	Mat6 r;
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j < 6; ++j) r(i, j) = a(i, j);
	return r;
}

/// Adds the response of one body: twist at the point, `arm` from its centre, to a unit impulse there.
void addResponse(Mat6& W, const btVolumetricRowBody& body, const ist::Vec3& point)
{
	const Eigen::Vector3d r = toEigen(point - body.center);
	Eigen::Matrix3d X;
	X << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
	Eigen::Matrix3d inertia;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) inertia(i, j) = body.inverseInertia.m[i][j];
	W.topLeftCorner<3, 3>() += X * inertia * X.transpose();
	W.topLeftCorner<3, 3>().diagonal() += toEigen(body.inverseMass);
	W.topRightCorner<3, 3>() -= X * inertia;
	W.bottomLeftCorner<3, 3>() += inertia * X;
	W.bottomRightCorner<3, 3>() += inertia;
}
}  // namespace

void btVolumetricRow::prepare(const btContactPatch& patch, const btVolumetricRowBody& A, const btVolumetricRowBody& B, double h,
							  double friction)
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
	MapMat6 W(m_W), S(m_S), inverse(m_B);
	W = toEigen(response);
	S = h * h * toEigen(patch.stiffness) + h * toEigen(patch.damping);
	inverse = (Mat6::Identity() + S * W).partialPivLu().inverse();
	MapVec6 push(m_push);
	push << h * toEigen(patch.wrench.force), h * toEigen(patch.wrench.torque);

	ist::Vec3 t1, t2;
	ist::completeFrame(patch.normal, t1, t2);
	Eigen::Map<Mat63> E(m_E);
	E.setZero();
	E.col(0).head<3>() = toEigen(t1);
	E.col(1).head<3>() = toEigen(t2);
	E.col(2).tail<3>() = patch.frictionRadius * toEigen(patch.normal);
	const Eigen::Matrix3d response3 = E.transpose() * (W * inverse) * E;
	const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(0.5 * (response3 + response3.transpose()));
	const double largest = eigen.eigenvalues()(2);
	m_slide = largest > 0 ? 1 / largest : 0;
	Eigen::Map<Eigen::Matrix3d> stick(m_stick);
	stick.setZero();
	for (int i = 0; i < 3; ++i)
	{
		const double value = eigen.eigenvalues()(i);
		const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
		if (value > kImmovable * largest) stick += axis * axis.transpose() / value;
	}
	MapVec6(m_elastic).setZero();
	Eigen::Map<Eigen::Vector3d>(m_tangent).setZero();
}

ist::Wrench btVolumetricRow::solve(const ist::Twist& relative)
{
	const ConstMat6 W(m_W), S(m_S), inverse(m_B);
	const ConstVec6 push(m_push);
	const ConstMat63 E(m_E);
	const Eigen::Vector3d n = toEigen(m_normal);
	MapVec6 elastic(m_elastic);
	Eigen::Map<Eigen::Vector3d> tangent(m_tangent);
	const auto normalPart = [&] { return n.dot(elastic.head<3>()); };
	const auto answerTo = [&](const Vec6& twist)
	{
		elastic = inverse * (push - S * twist);
		if (!(normalPart() > 0)) elastic.setZero();
	};

	const Vec6 before = elastic + E * tangent;
	Vec6 without;
	without << toEigen(relative.linear), toEigen(relative.angular);
	without -= W * before;
	answerTo(without + W * (E * tangent));
	const double limit = m_friction * normalPart();
	if (limit > 0)
	{
		const Eigen::Vector3d slip = E.transpose() * (without + W * (elastic + E * tangent));
		Eigen::Vector3d wanted = tangent - Eigen::Map<const Eigen::Matrix3d>(m_stick) * slip;
		// Sliding: along the slip itself. Scaling `wanted` back would turn the force towards the directions that move easily.
		if (wanted.norm() > limit) wanted = tangent - m_slide * slip;
		tangent = wanted.norm() > limit ? Eigen::Vector3d(wanted * (limit / wanted.norm())) : wanted;
		answerTo(without + W * (E * tangent));
	}
	const double finalLimit = m_friction * normalPart();
	if (tangent.norm() > finalLimit) tangent *= finalLimit / tangent.norm();

	const Vec6 change = elastic + E * tangent - before;
	return {{change(0), change(1), change(2)}, {change(3), change(4), change(5)}};
}

ist::Wrench btVolumetricRow::impulse() const
{
	const Vec6 total = ConstVec6(m_elastic) + ConstMat63(m_E) * Eigen::Map<const Eigen::Vector3d>(m_tangent);
	return {{total(0), total(1), total(2)}, {total(3), total(4), total(5)}};
}

ist::Wrench btVolumetricRow::elasticImpulse() const
{
	return {{m_elastic[0], m_elastic[1], m_elastic[2]}, {m_elastic[3], m_elastic[4], m_elastic[5]}};
}

double btVolumetricRow::normalImpulse() const { return ConstVec6(m_elastic).head<3>().dot(toEigen(m_normal)); }
