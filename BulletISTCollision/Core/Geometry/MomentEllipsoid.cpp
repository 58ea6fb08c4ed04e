// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Geometry/MomentEllipsoid.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace ist
{
namespace
{
// Two ellipsoids can reach beyond their bounding balls and are cut there (Lens.h). With balls no larger than the ellipsoids this costs a
// few tenths of a percent of every volume; with this factor it costs a few hundredths (bench_truth).
constexpr double kReach = 1.03;
// P over the second moment per volume, for a homogeneous ellipsoid.
constexpr double kShapePerMoment = 5;
// Shapes from few samples vary. Enlarging them to their piece's full volume would make them too large on average.
constexpr double kLeastVolume = 1.0 / 3;

Eigen::Matrix3d matrixOf(const SymmetricMatrix3& m)
{
	Eigen::Matrix3d M;
	M << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
	return M;
}

/// The entries of a symmetric matrix.
SymmetricMatrix3 entriesOf(const Eigen::Matrix3d& M) { return {M(0, 0), M(1, 1), M(2, 2), M(0, 1), M(0, 2), M(1, 2)}; }

/// The upper half of the nearest float whose lower half is zero; ties go to even.
uint32_t halfOf(double v)
{
	const uint32_t bits = std::bit_cast<uint32_t>(float(v));
	return (bits + 0x7fff + (bits >> 16 & 1)) >> 16;
}
}  // namespace

StoredEllipsoid::StoredEllipsoid(const MomentEllipsoid& e) : density(e.density), depth(e.depth), sphere(e.sphere)
{
	const double steps = 1 / double(kStep), perSquare = steps / (double(e.R) * e.R);
	const float n[3] = {e.nx, e.ny, e.nz}, P[6] = {e.xx, e.yy, e.zz, e.xy, e.xz, e.yz};
	// A component can exceed 1, or R^2, by a rounding. A NaN is passed on as a NaN density, so that the tree is refused.
	const auto rounded = [&](double v) {
		if (!(std::fabs(v) < 1.001 * steps)) density = std::numeric_limits<float>::quiet_NaN();
		return int16_t(std::fabs(v) <= steps ? std::lround(v) : v > 0 ? 32767 : -32767);
	};
	for (int i = 0; i < 3; ++i) normal[i] = rounded(n[i] * steps);
	if (!(e.R > 0)) return;
	for (int i = 0; i < 6; ++i) shape[i] = rounded(P[i] * perSquare);
}

SymmetricMatrix3 NormalGradient::matrix() const
{
	const auto above = [&](int i) { return double(std::bit_cast<float>(diagonalOverRest[i] & 0xffff0000)); };
	const auto below = [&](int i) { return double(std::bit_cast<float>(diagonalOverRest[i] << 16)); };
	return {above(0), above(1), above(2), below(0), below(1), below(2)};
}

void NormalGradient::setMatrix(const SymmetricMatrix3& G)
{
	const double diagonal[3] = {G.xx, G.yy, G.zz}, rest[3] = {G.xy, G.xz, G.yz};
	for (int i = 0; i < 3; ++i) diagonalOverRest[i] = halfOf(diagonal[i]) << 16 | halfOf(rest[i]);
}

MomentEllipsoid momentEllipsoid(const Vec3& centroid, const SymmetricMatrix3& shape, double volume)
{
	const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrixOf(shape));
	Eigen::Vector3d squares = solver.eigenvalues();
	squares = squares.cwiseMax(MomentEllipsoid::kFlattest * MomentEllipsoid::kFlattest * squares.maxCoeff());
	const double own = kUnitBall * std::sqrt(squares.prod());
	if (!(own > 0)) squares.setConstant(std::pow(volume / kUnitBall, 2.0 / 3));
	else if (own < kLeastVolume * volume) squares *= std::pow(kLeastVolume * volume / own, 2.0 / 3);
	const Eigen::Matrix3d kept = solver.eigenvectors() * squares.asDiagonal() * solver.eigenvectors().transpose();

	MomentEllipsoid e;
	e.setPlace(centroid);
	e.setShape(entriesOf(kept));
	e.R = float(std::sqrt(squares.maxCoeff()) * kReach);
	// The density uses the rounded radius, so that the rounding loses no volume.
	e.density = float(volume / (kUnitBall * double(e.R) * e.R * e.R));
	return e;
}

MomentEllipsoid merged(const MomentEllipsoid* pieces, const uint32_t* index, size_t count)
{
	if (count == 1) return pieces[index[0]];
	double volume = 0, depth = 0;
	Vec3 first, normal;
	for (size_t i = 0; i < count; ++i)
	{
		const MomentEllipsoid& piece = pieces[index[i]];
		const double v = piece.volume();
		volume += v;
		first += v * piece.center();
		normal += v * piece.normal();
		depth += v * piece.depth;
	}
	if (!(volume > 0)) return pieces[index[0]];
	const Vec3 centroid = first / volume;
	SymmetricMatrix3 shape;
	for (size_t i = 0; i < count; ++i)
	{
		const MomentEllipsoid& piece = pieces[index[i]];
		shape += (piece.shape() + SymmetricMatrix3::square(piece.center() - centroid) * kShapePerMoment) * (piece.volume() / volume);
	}
	MomentEllipsoid whole = momentEllipsoid(centroid, shape, volume);
	whole.setNormal(normal / volume);
	whole.depth = float(depth / volume);
	whole.sphere = pieces[index[0]].sphere;
	return whole;
}

SymmetricMatrix3 normalGradient(const MomentEllipsoid& whole, const MomentEllipsoid* pieces, const uint32_t* index, size_t count)
{
	if (count < 2) return {};
	const auto vector = [](const Vec3& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
	Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();
	for (size_t i = 0; i < count; ++i)
	{
		const MomentEllipsoid& piece = pieces[index[i]];
		slope += piece.volume() * vector(piece.normal() - whole.normal()) * vector(piece.center() - whole.center()).transpose();
	}
	// Least squares among symmetric matrices, G S + S G = C + C^T, in the axes of S. Pieces that lie in one layer do not determine the
	// change across it.
	const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(matrixOf(whole.shape() * (whole.volume() / kShapePerMoment)));
	const Eigen::Matrix3d& Q = axes.eigenvectors();
	Eigen::Matrix3d G = Q.transpose() * (slope + slope.transpose()) * Q;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) G(i, j) /= axes.eigenvalues()[i] + axes.eigenvalues()[j];
	G = Q * G * Q.transpose();
	return G.allFinite() ? entriesOf(G) : SymmetricMatrix3();
}
}  // namespace ist
