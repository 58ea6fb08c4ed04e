// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btIslandBlockSolver.h"

#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat3 = Eigen::Matrix3d;
using Mat6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Axes = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;  // an axis a row
using Mat63 = Eigen::Matrix<double, 6, 3>;
using Mat46 = Eigen::Matrix<double, 4, 6>;
using Vector = Eigen::VectorXd;
template <class M> using Map = Eigen::Map<M>;

// Rounds in which all patches that would push come back into the active set; then, one at a time, which seldom cycles; then none, so
// that the search ends.
constexpr int kRoundsOfAll = 2, kRoundsOfOne = 12;
constexpr int kMaxSweeps = 400;
// Where many patches share one load, sticking and sliding may take turns for ever at a hundred-thousandth of the load: the search ends
// when so many sweeps have not brought the change down to this share of what it was. What they would still find goes into the next step's
// beginning.
constexpr int kPatience = 24;
constexpr double kProgress = 0.5;
// Sweeps and their combinations carry the state along, and with it rounding, which may double from one to the next. It is made anew from
// the impulses after so many, and at the end.
constexpr int kTrust = 8;
// Friction is done when no impulse changes by more than this share of the largest normal impulse: about a rounding of single precision.
// What sticks then creeps by no more than this share of g h, since the next step begins where this one ends.
constexpr double kFrictionTolerance = 1e-7;
// Friction that sweeps which did not end have left beyond its limit is cut down, and the normal impulses, which this changes, are found
// anew. Cuts go the farther below the limit the later they come, and after so many to nothing, so that they end: what has no friction is
// not cut again.
constexpr int kCutsToNothing = 50;
constexpr double kImmovable = 1e-12;
// Of the search for a sliding patch's friction; steps double the digits.
constexpr int kMostNewtonSteps = 20;
constexpr double kLimitTolerance = 1e-12;

Eigen::Vector3d toEigen(const ist::Vec3& v) { return {v.x, v.y, v.z}; }

Mat3 crossMatrix(const ist::Vec3& v)
{
	Mat3 r;
	r << 0, -v.z, v.y, v.z, 0, -v.x, -v.y, v.x, 0;
	return r;
}

Vec6 toEigen(const ist::Vec3& a, const ist::Vec3& b)
{
	Vec6 r;
	r << a.x, a.y, a.z, b.x, b.y, b.z;
	return r;
}

Mat6 toEigen(const ist::SymmetricMatrix6& a)
{
	Mat6 r;
	const double* next = a.m;
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) r(i, j) = r(j, i) = *next++;
	return r;
}

Mat6 rootOfInverseMass(const btVolumetricRowBody& body)
{
	double inertia[3][3];
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) inertia[i][j] = 0.5 * (body.inverseInertia.m[i][j] + body.inverseInertia.m[j][i]);
	Mat6 root = Mat6::Zero();
	root.topLeftCorner<3, 3>().diagonal() = toEigen(body.inverseMass).cwiseMax(0.0).cwiseSqrt();
	ist::SymmetricEigen<3> eigen;
	if (!eigen.decompose(inertia)) return Mat6::Constant(std::numeric_limits<double>::quiet_NaN());  // refused when it is factorised
	const Map<const Axes> axes(eigen.vectors[0]);
	const Eigen::Array3d values = Map<const Eigen::Array3d>(eigen.values).max(0.0);
	root.bottomRightCorner<3, 3>() = axes.transpose() * values.sqrt().matrix().asDiagonal() * axes;
	return root;
}

/// The friction of one patch, no longer than `limit`, that leaves as little slip as it can, all along the axes in which the slip answers to
/// each part of it alone, `yielding` times: (yielding + m) wanted = yielding now - slip, with the smallest m >= 0 that keeps the limit.
/// Newton's method for 1/|wanted|, which comes from below and does not overshoot; from above one step leads below. `excess`: m, and where
/// the search for it begins.
Eigen::Vector3d frictionWithin(
	double limit, const Eigen::Vector3d& now, const Eigen::Vector3d& slip, const double* yielding, double& excess)
{
	Eigen::Vector3d wanted;
	for (int i = 0; i < 3; ++i) wanted(i) = yielding[i] > 0 ? now(i) - slip(i) / yielding[i] : now(i);
	if (wanted.squaredNorm() <= limit * limit) return wanted;
	if (!(limit > 0)) return Eigen::Vector3d::Zero();
	Eigen::Vector3d pull;
	double least = 0;
	for (int i = 0; i < 3; ++i)
	{
		pull(i) = yielding[i] * now(i) - slip(i);
		least = std::max(least, std::fabs(pull(i)) / limit - yielding[i]);
	}
	excess = std::max(excess, least);
	double length = limit;
	for (int i = 0; i < kMostNewtonSteps; ++i)
	{
		double square = 0, slope = 0;
		for (int k = 0; k < 3; ++k)
		{
			const double inverse = yielding[k] + excess > 0 ? 1 / (yielding[k] + excess) : 0;
			wanted(k) = pull(k) * inverse;
			square += wanted(k) * wanted(k);
			slope += wanted(k) * wanted(k) * inverse;
		}
		length = std::sqrt(square);
		if (std::fabs(length - limit) <= kLimitTolerance * limit || !(slope > 0)) break;
		excess = std::max(excess + (length - limit) * square / (limit * slope), least);
	}
	return wanted * (limit / std::max(limit, length));
}
}  // namespace

void btIslandBlockSolver::reserve(int bodies, int patches)
{
	const size_t stride = 6 * size_t(bodies);
	m_bodies.resize(std::max(m_bodies.size(), size_t(bodies)));
	m_patches.resize(std::max(m_patches.size(), size_t(patches)));
	m_order.reserve(size_t(bodies));
	m_first.reserve(stride);
	m_factor.reserve(stride * stride);
	for (auto* perBody : {&m_free, &m_z}) perBody->resize(std::max(perBody->size(), stride));
	m_scratch.resize(std::max(m_scratch.size(), 6 * stride));
	m_response.resize(std::max(m_response.size(), 3 * stride * size_t(patches)));
	m_tangents.resize(std::max(m_tangents.size(), 3 * size_t(patches)));
	m_acceleration.reserve(3 * size_t(patches), stride);
}

void btIslandBlockSolver::clear()
{
	m_bodyCount = m_patchCount = 0;
	m_frictionPrepared = false;
}

int btIslandBlockSolver::addBody(const btVolumetricRowBody& body)
{
	if (m_bodyCount == int(m_bodies.size())) m_bodies.emplace_back();
	Body& b = m_bodies[size_t(m_bodyCount)];
	Map<Mat6>(b.root) = rootOfInverseMass(body);
	b.center = body.center;
	return m_bodyCount++;
}

int btIslandBlockSolver::addPatch(const btContactPatch& patch, int bodyA, int bodyB, const ist::Twist& given, double h, double friction)
{
	if (m_patchCount == int(m_patches.size())) m_patches.emplace_back();
	m_tangents.resize(std::max(m_tangents.size(), 3 * m_patches.size()));
	Patch& p = m_patches[size_t(m_patchCount)];
	p.point = patch.point;
	p.normal = patch.normal;
	p.body[0] = bodyA;
	p.body[1] = bodyB;
	p.friction = friction;
	p.active = true;
	p.excess = 0;
	Map<Mat6>(p.S) = h * h * toEigen(patch.stiffness) + h * toEigen(patch.damping);
	Map<Vec6>(p.push) = h * toEigen(patch.wrench.force, patch.wrench.torque);
	Map<Vec6>(p.given) = toEigen(given.linear, given.angular);
	Map<Vec6>(p.elastic).setZero();
	Map<Eigen::Vector3d>(tangent(m_patchCount)).setZero();
	for (int side = 0; side < 2; ++side)
	{
		if (p.body[side] < 0) continue;
		const Body& body = m_bodies[size_t(p.body[side])];
		// Of a root whose mixed quarters are zero.
		Map<Mat6> J(p.jacobian[side]);
		J = (side == 0 ? 1.0 : -1.0) * Map<const Mat6>(body.root);
		J.topRightCorner<3, 3>().noalias() -= crossMatrix(patch.point - body.center) * J.bottomRightCorner<3, 3>();
	}
	ist::Vec3 t1, t2;
	ist::completeFrame(patch.normal, t1, t2);
	Map<Mat63> E(p.E);
	E.setZero();
	E.col(0).head<3>() = toEigen(t1);
	E.col(1).head<3>() = toEigen(t2);
	E.col(2).tail<3>() = patch.frictionRadius * toEigen(patch.normal);
	return m_patchCount++;
}

void btIslandBlockSolver::startFriction(int patch, const ist::Wrench& impulse)
{
	const Patch& p = m_patches[size_t(patch)];
	if (!(p.friction > 0)) return;
	const Map<const Mat63> E(p.E);
	const Vec6 whole = toEigen(impulse.force, impulse.torque);
	for (int i = 0; i < 3; ++i)
	{
		const double square = E.col(i).squaredNorm();
		tangent(patch)[i] = square > 0 ? E.col(i).dot(whole) / square : 0;
	}
}

// Breadth first from the body with the fewest neighbours, and then the other way round: neighbours stay close together,
// and a body with many of them, as what a hand holds, comes after them. So the envelope is small.
void btIslandBlockSolver::orderBodies()
{
	m_order.clear();
	for (int b = 0; b < m_bodyCount; ++b) m_bodies[size_t(b)].place = -1;
	const auto degree = [this](int b) {
		return std::count_if(m_patches.begin(), m_patches.begin() + m_patchCount,
			[b](const Patch& p) { return (p.body[0] == b || p.body[1] == b) && p.body[0] >= 0 && p.body[1] >= 0; });
	};
	while (int(m_order.size()) < m_bodyCount)
	{
		int start = -1;
		for (int b = 0; b < m_bodyCount; ++b)
			if (m_bodies[size_t(b)].place < 0 && (start < 0 || degree(b) < degree(start))) start = b;
		size_t next = m_order.size();
		m_bodies[size_t(start)].place = int(m_order.size());
		m_order.push_back(start);
		for (; next < m_order.size(); ++next)
			for (int i = 0; i < m_patchCount; ++i)
				for (int side = 0; side < 2; ++side)
				{
					const Patch& p = m_patches[size_t(i)];
					const int other = p.body[1 - side];
					if (p.body[side] != m_order[next] || other < 0 || m_bodies[size_t(other)].place >= 0) continue;
					m_bodies[size_t(other)].place = int(m_order.size());
					m_order.push_back(other);
				}
	}
	std::reverse(m_order.begin(), m_order.end());
	for (int i = 0; i < m_bodyCount; ++i) m_bodies[size_t(m_order[size_t(i)])].place = i;
}

bool btIslandBlockSolver::factorise()
{
	const int n = 6 * m_bodyCount;
	m_first.assign(size_t(n), 0);
	m_factor.assign(size_t(n) * size_t(n), 0.0);
	for (int i = 0; i < n; ++i)
	{
		m_first[size_t(i)] = i - i % 6;
		m_factor[size_t(i) * size_t(n) + size_t(i)] = 1;
	}
	for (int k = 0; k < m_patchCount; ++k)
	{
		const Patch& p = m_patches[size_t(k)];
		if (!p.active) continue;
		for (int row = 0; row < 2; ++row)
			for (int column = 0; column < 2; ++column)
			{
				if (p.body[row] < 0 || p.body[column] < 0 || placeOf(p, row) < placeOf(p, column)) continue;
				const Mat6 block = Map<const Mat6>(p.jacobian[row]).transpose() * Map<const Mat6>(p.S) *
					Map<const Mat6>(p.jacobian[column]);
				const int r = placeOf(p, row), c = placeOf(p, column);
				for (int i = 0; i < 6; ++i)
				{
					m_first[size_t(r + i)] = std::min(m_first[size_t(r + i)], c);
					for (int j = 0; j < 6; ++j) m_factor[size_t(r + i) * size_t(n) + size_t(c + j)] += block(i, j);
				}
			}
	}
	for (int i = 0; i < n; ++i)
	{
		double* rowI = &m_factor[size_t(i) * size_t(n)];
		for (int j = m_first[size_t(i)]; j <= i; ++j)
		{
			const double* rowJ = &m_factor[size_t(j) * size_t(n)];
			const int from = std::max(m_first[size_t(i)], m_first[size_t(j)]);
			const double rest = rowI[j] - Map<const Vector>(rowI + from, j - from).dot(Map<const Vector>(rowJ + from, j - from));
			if (i == j && !(rest > 0)) return false;
			rowI[j] = i == j ? 1 / std::sqrt(rest) : rest * rowJ[j];
		}
	}
	return true;
}

int64_t btIslandBlockSolver::envelopeEntries() const
{
	int64_t entries = 0;
	for (int i = 0; i < 6 * m_bodyCount; ++i) entries += i + 1 - m_first[size_t(i)];
	return entries;
}

/// `x`: right-hand sides side by side, in the order of elimination, zero before `begin`.
template <int N> void btIslandBlockSolver::backSubstitute(double* x, int begin) const
{
	using Side = Eigen::Matrix<double, N, 1>;
	const int n = 6 * m_bodyCount;
	const auto at = [x](int i) { return Map<Side>(x + N * i); };
	for (int i = begin; i < n; ++i)
	{
		const double* row = &m_factor[size_t(i) * size_t(n)];
		Side rest = at(i);
		for (int j = std::max(m_first[size_t(i)], begin); j < i; ++j) rest -= row[j] * at(j);
		at(i) = row[i] * rest;
	}
	for (int i = n - 1; i >= 0; --i)
	{
		const double* row = &m_factor[size_t(i) * size_t(n)];
		const Side found = row[i] * at(i);
		at(i) = found;
		for (int j = m_first[size_t(i)]; j < i; ++j) at(j) -= row[j] * found;
	}
}

/// Of A minus B at the point, with the state `m_z`.
void btIslandBlockSolver::relativeTwist(const Patch& p, double* twist) const
{
	Map<Vec6> u(twist);
	u = Map<const Vec6>(p.given);
	for (int side = 0; side < 2; ++side)
	{
		if (p.body[side] < 0) continue;
		const Body& body = m_bodies[size_t(p.body[side])];
		const Map<const Vec6> free(&m_free[6 * size_t(p.body[side])]);
		Vec6 atPoint = free;
		atPoint.head<3>() += free.tail<3>().cross(toEigen(p.point - body.center));
		u += (side == 0 ? 1.0 : -1.0) * atPoint + Map<const Mat6>(p.jacobian[side]) * Map<const Vec6>(&m_z[6 * size_t(body.place)]);
	}
}

/// Where the pushes of a patch begin, in the order of elimination.
int btIslandBlockSolver::firstPlace(const Patch& p) const
{
	int first = 6 * m_bodyCount;
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0) first = std::min(first, placeOf(p, side));
	return first;
}

/// R J^T impulse, added to `target` in the order of elimination.
void btIslandBlockSolver::addPush(const Patch& p, const double* impulse, double* target) const
{
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0)
			Map<Vec6>(target + placeOf(p, side)) += Map<const Mat6>(p.jacobian[side]).transpose() * Map<const Vec6>(impulse);
}

/// `m_z` with the elastic answer and the friction impulses so far; what friction asks for without any impulse.
void btIslandBlockSolver::solveElastic()
{
	std::fill(m_z.begin(), m_z.begin() + 6 * m_bodyCount, 0.0);
	// `m_z` must be zero while the right-hand side is made: it is the state without any impulse.
	double* right = scratch();
	std::fill(right, right + 6 * m_bodyCount, 0.0);
	for (int k = 0; k < m_patchCount; ++k)
	{
		Patch& p = m_patches[size_t(k)];
		if (!p.active) continue;
		Vec6 u;
		relativeTwist(p, u.data());
		const Vec6 elastic = Map<const Vec6>(p.push) - Map<const Mat6>(p.S) * u;
		const Vec6 push = elastic + Map<const Mat63>(p.E) * Map<const Eigen::Vector3d>(tangent(k));
		addPush(p, push.data(), right);
		Map<Eigen::Vector4d>(p.askedAtRest) << Map<const Mat63>(p.E).transpose() * u, elastic.head<3>().dot(toEigen(p.normal));
	}
	backSubstitute<1>(right, 0);
	std::copy(right, right + 6 * m_bodyCount, m_z.begin());
}

/// By the bodies of the patch: how the slip and the elastic normal impulse change with the state.
void btIslandBlockSolver::prepareAsked(Patch& p) const
{
	Mat46 ofTwist;
	ofTwist << Map<const Mat63>(p.E).transpose(), -toEigen(p.normal).transpose() * Map<const Mat6>(p.S).topRows<3>();
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0) Map<Mat46>(p.asked[side]) = ofTwist * Map<const Mat6>(p.jacobian[side]);
}

void btIslandBlockSolver::prepareFriction()
{
	const size_t stride = 6 * size_t(m_bodyCount);
	for (int k = 0; k < m_patchCount; ++k)
	{
		Patch& p = m_patches[size_t(k)];
		if (!p.active || !(p.friction > 0)) continue;
		prepareAsked(p);
		// A fourth column, which stays zero, makes of each row two vectors of the processor.
		using Columns = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;
		Map<Columns> columns(scratch(), Eigen::Index(stride), 4);
		columns.setZero();
		for (int side = 0; side < 2; ++side)
			if (p.body[side] >= 0)
				columns.block<6, 3>(placeOf(p, side), 0) += Map<const Mat6>(p.jacobian[side]).transpose() * Map<const Mat63>(p.E);
		backSubstitute<4>(columns.data(), firstPlace(p));
		Mat3 G = Mat3::Zero();
		for (int side = 0; side < 2; ++side)
			if (p.body[side] >= 0) G += Map<const Mat46>(p.asked[side]).topRows<3>() * columns.block<6, 3>(placeOf(p, side), 0);
		Map<Eigen::Matrix<double, Eigen::Dynamic, 3>>(&m_response[3 * stride * size_t(k)], Eigen::Index(stride), 3) = columns.leftCols<3>();
		double yielding[3][3];
		Map<Axes> symmetric(yielding[0]);
		symmetric = 0.5 * (G + G.transpose());
		ist::SymmetricEigen<3> eigen;
		if (!eigen.decompose(yielding)) eigen = {};  // not finite: no friction
		Map<Axes>(p.axes) = Map<const Axes>(eigen.vectors[0]);
		const Map<const Eigen::Vector3d> values(eigen.values);
		Map<Eigen::Vector3d>(p.yielding) = (values.array() > kImmovable * values.maxCoeff()).select(values, 0.0);
	}
	m_frictionPrepared = true;
}

/// One visit of a patch while the others stay as they are. Gives how much its friction changed, and by which normal impulse it is pressed.
double btIslandBlockSolver::visitFriction(int patch, double& normal)
{
	Patch& p = m_patches[size_t(patch)];
	Eigen::Vector4d asked = Map<const Eigen::Vector4d>(p.askedAtRest);
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0) asked += Map<const Mat46>(p.asked[side]) * Map<const Vec6>(&m_z[size_t(placeOf(p, side))]);
	normal = std::max(asked(3), 0.0);
	Map<Eigen::Vector3d> now(tangent(patch));
	const Map<const Axes> axes(p.axes);
	const Eigen::Vector3d wanted = axes.transpose() *
		frictionWithin(p.friction * normal, axes * now, axes * asked.head<3>(), p.yielding, p.excess);
	const Eigen::Vector3d change = wanted - now;
	now = wanted;
	const Eigen::Index stride = 6 * Eigen::Index(m_bodyCount);
	const double* columns = &m_response[3 * size_t(stride) * size_t(patch)];
	const auto column = [&](int c) { return Map<const Vector>(columns + stride * c, stride); };
	if (!change.isZero(0)) Map<Vector>(m_z.data(), stride) += change(0) * column(0) + change(1) * column(1) + change(2) * column(2);
	return change.norm();
}

void btIslandBlockSolver::iterateFriction()
{
	double largestNormal = 0, before = 0;
	m_acceleration.begin(m_tangents.data(), 3 * size_t(m_patchCount), 6 * size_t(m_bodyCount));
	for (m_sweeps = 0; m_sweeps < kMaxSweeps; ++m_sweeps)
	{
		m_remainingChange = 0;
		for (int k = 0; k < m_patchCount; ++k)
		{
			if (!m_patches[size_t(k)].active || !(m_patches[size_t(k)].friction > 0)) continue;
			double normal = 0;
			m_remainingChange = std::max(m_remainingChange, visitFriction(k, normal));
			largestNormal = std::max(largestNormal, normal);
		}
		m_frictionNotConverged = m_remainingChange > kFrictionTolerance * largestNormal;
		if (!m_frictionNotConverged || m_sweeps == kMaxSweeps - 1) break;
		if (m_sweeps % kPatience == kPatience - 1)
		{
			if (m_sweeps >= kPatience && m_remainingChange > kProgress * before) break;
			before = m_remainingChange;
		}
		m_acceleration.advance(m_tangents.data(), m_z.data());
		if (m_sweeps % kTrust == kTrust - 1) solveElastic();
	}
	if (m_sweeps > 0) solveElastic();
	if (!m_frictionNotConverged) return;
	for (int i = 0; cutFriction(kFrictionTolerance * largestNormal, std::max(1 - double(i) / kCutsToNothing, 0.0)); ++i) solveElastic();
}

/// Friction that is by more than `tolerance` [N s] beyond its limit at the normal impulse of the state becomes `share` of the limit. True
/// when there was such.
bool btIslandBlockSolver::cutFriction(double tolerance, double share)
{
	bool cut = false;
	for (int k = 0; k < m_patchCount; ++k)
	{
		const Patch& p = m_patches[size_t(k)];
		if (!p.active) continue;
		Vec6 u;
		relativeTwist(p, u.data());
		const Vec6 elastic = Map<const Vec6>(p.push) - Map<const Mat6>(p.S) * u;
		const double limit = p.friction * std::max(elastic.head<3>().dot(toEigen(p.normal)), 0.0);
		Map<Eigen::Vector3d> friction(tangent(k));
		const double length = friction.norm();
		if (!(length > limit + tolerance)) continue;
		friction *= share * limit / length;
		cut = true;
	}
	return cut;
}

/// Of a patch that is out: whether its impulse would push if it were in. The test of the force at this state alone would bring
/// back patches that pull as soon as they act.
bool btIslandBlockSolver::wouldPush(const Patch& p)
{
	using Columns = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;
	Map<Columns> columns(scratch(), 6 * m_bodyCount, 6);
	columns.setZero();
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0) columns.middleRows<6>(placeOf(p, side)) += Map<const Mat6>(p.jacobian[side]).transpose();
	backSubstitute<6>(columns.data(), firstPlace(p));
	Mat6 W = Mat6::Zero();
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0) W += Map<const Mat6>(p.jacobian[side]) * columns.middleRows<6>(placeOf(p, side));
	Vec6 u;
	relativeTwist(p, u.data());
	const Map<const Mat6> S(p.S);
	const Vec6 answer = (Mat6::Identity() + S * W).partialPivLu().solve(Map<const Vec6>(p.push) - S * u);
	return answer.head<3>().dot(toEigen(p.normal)) > 0;
}

/// Stores the elastic impulses; true when a patch would pull and leaves, or when one that was out would push and comes back.
bool btIslandBlockSolver::changeActiveSet(int mayReturn)
{
	bool changed = false;
	for (int k = 0; k < m_patchCount; ++k)
	{
		Patch& p = m_patches[size_t(k)];
		if (p.active)
		{
			Vec6 u;
			relativeTwist(p, u.data());
			Map<Vec6> elastic(p.elastic);
			elastic = Map<const Vec6>(p.push) - Map<const Mat6>(p.S) * u;
			if (elastic.head<3>().dot(toEigen(p.normal)) > 0) continue;
			p.active = false;
			changed = true;
		}
		else if (mayReturn > 0 && wouldPush(p))
		{
			p.active = changed = true;
			--mayReturn;
		}
		Map<Vec6> elastic(p.elastic);
		elastic.setZero();
		Map<Eigen::Vector3d>(tangent(k)).setZero();
	}
	return changed;
}

bool btIslandBlockSolver::solve(const ist::Twist* free)
{
	reserve(m_bodyCount, m_patchCount);
	for (int b = 0; b < m_bodyCount; ++b)
	{
		Map<Vec6> twist(&m_free[6 * size_t(b)]);
		twist = toEigen(free[b].linear, free[b].angular);
	}
	m_frictionNotConverged = false;
	for (int round = 0;; ++round)
	{
		m_rounds = round;
		if (!m_frictionPrepared)
		{
			if (round == 0) orderBodies();
			if (!factorise())
			{
				for (int k = 0; k < m_patchCount; ++k)
				{
					Map<Vec6>(m_patches[size_t(k)].elastic).setZero();
					Map<Eigen::Vector3d>(tangent(k)).setZero();
				}
				return false;
			}
			prepareFriction();
		}
		solveElastic();
		iterateFriction();
		const int mayReturn = round < kRoundsOfAll ? m_patchCount : round < kRoundsOfAll + kRoundsOfOne ? 1 : 0;
		if (!changeActiveSet(mayReturn)) return true;
		m_frictionPrepared = false;
	}
}

ist::Wrench btIslandBlockSolver::impulse(int patch) const
{
	const Patch& p = m_patches[size_t(patch)];
	const Vec6 total = Map<const Vec6>(p.elastic) + Map<const Mat63>(p.E) * Map<const Eigen::Vector3d>(tangent(patch));
	return {{total(0), total(1), total(2)}, {total(3), total(4), total(5)}};
}

ist::Wrench btIslandBlockSolver::elasticImpulse(int patch) const
{
	const double* e = m_patches[size_t(patch)].elastic;
	return {{e[0], e[1], e[2]}, {e[3], e[4], e[5]}};
}

double btIslandBlockSolver::normalImpulse(int patch) const
{
	const Patch& p = m_patches[size_t(patch)];
	return Map<const Vec6>(p.elastic).head<3>().dot(toEigen(p.normal));
}
