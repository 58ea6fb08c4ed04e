// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btIslandBlockSolver.h"

#include "BulletHapticForce/Solver/btIslandBlockMatrices.h"
#include "BulletHapticForce/Solver/btToEigen.h"
#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace btIslandBlockMatrices;
using namespace btToEigen;

namespace
{
// In the first rounds all patches that would push return to the active set. In the next rounds one patch returns at a time, which seldom
// cycles. After that none returns, so that the search ends. Of 20,000 islands of bodies that fall into a bin, 65 needed more rounds.
constexpr int kRoundsOfAll = 2, kRoundsOfOne = 40;
constexpr int kMaxRefinements = 3;  // of the impulses of joints
constexpr int kMaxSearches = 8;     // of the rows of joints at their limits, after friction has changed them

Mat6 rootOfInverseMass(const btVolumetricRowBody& body)
{
	double inertia[3][3];
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) inertia[i][j] = 0.5 * (body.inverseInertia.m[i][j] + body.inverseInertia.m[j][i]);
	Mat6 root = Mat6::Zero();
	root.topLeftCorner<3, 3>().diagonal() = toEigen(body.inverseMass).cwiseMax(0.0).cwiseSqrt();
	ist::SymmetricEigen<3> eigen;
	if (!eigen.decompose(inertia)) return Mat6::Constant(std::numeric_limits<double>::quiet_NaN());  // refused by the factorisation
	const Map<const Axes> axes(eigen.vectors[0]);
	const Eigen::Array3d values = Map<const Eigen::Array3d>(eigen.values).max(0.0);
	root.bottomRightCorner<3, 3>() = axes.transpose() * values.sqrt().matrix().asDiagonal() * axes;
	return root;
}
}  // namespace

void btIslandBlockSolver::reserve(int bodies, int patches)
{
	const size_t stride = 6 * size_t(bodies), frictions = std::max(size_t(patches), size_t(m_frictionCount));
	m_bodies.resize(std::max(m_bodies.size(), size_t(bodies)));
	m_patches.resize(std::max(m_patches.size(), size_t(patches)));
	m_frictions.resize(std::max(m_frictions.size(), frictions));
	m_order.reserve(size_t(bodies));
	m_factor.reserve(bodies);
	m_byBody.reserve(size_t(bodies), 2 * size_t(patches));
	m_byPlace.reserve(size_t(bodies), frictions);
	m_stuckFactor.reserve(bodies);
	for (auto* perBody : {&m_free, &m_z, &m_rest, &m_stateStep}) perBody->resize(std::max(perBody->size(), stride));
	m_response.reserve(3 * stride * frictions);
	for (auto* tangents : {&m_tangents, &m_tangentsBefore}) tangents->resize(std::max(tangents->size(), 3 * frictions));
	m_acceleration.reserve(3 * frictions);
}

void btIslandBlockSolver::clear()
{
	m_bodyCount = m_patchCount = m_frictionCount = 0;
	m_joints.clear();
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

int btIslandBlockSolver::addPatch(
	const btContactPatch& patch, int bodyA, int bodyB, const ist::Twist& given, double h, const btContactFriction& friction)
{
	if (m_patchCount == int(m_patches.size())) m_patches.emplace_back();
	Patch& p = m_patches[size_t(m_patchCount)];
	p.point = patch.point;
	p.normal = patch.normal;
	p.body[0] = bodyA;
	p.body[1] = bodyB;
	p.active = true;
	p.returns = 0;
	Map<Mat6>(p.S) = h * h * toEigen(patch.stiffness) + h * toEigen(patch.damping);
	Map<Vec6>(p.push) = h * toEigen(patch.wrench.force, patch.wrench.torque);
	Map<Vec6>(p.given) = toEigen(given.linear, given.angular);
	Map<Vec6>(p.elastic).setZero();
	for (int side = 0; side < 2; ++side)
	{
		if (p.body[side] < 0) continue;
		const Body& body = m_bodies[size_t(p.body[side])];
		// The off-diagonal quarters of `root` are zero.
		Map<Mat6> J(p.jacobian[side]);
		J = (side == 0 ? 1.0 : -1.0) * Map<const Mat6>(body.root);
		J.topRightCorner<3, 3>().noalias() -= crossMatrix(toEigen(patch.point - body.center)) * J.bottomRightCorner<3, 3>();
	}
	p.firstFriction = m_frictionCount;
	btFrictionBall balls[btContactFriction::kMostBalls];
	const int count = friction.balls(patch, balls);
	for (int i = 0; i < count; ++i) addFriction(m_patchCount, balls[i]);
	p.frictionEnd = m_frictionCount;
	return m_patchCount++;
}

void btIslandBlockSolver::addFriction(int patch, const btFrictionBall& ball)
{
	if (m_frictionCount == int(m_frictions.size())) m_frictions.emplace_back();
	m_tangents.resize(std::max(m_tangents.size(), 3 * m_frictions.size()));
	Friction& f = m_frictions[size_t(m_frictionCount)];
	f.patch = patch;
	f.coefficient = ball.coefficient;
	std::copy(std::begin(ball.E), std::end(ball.E), f.E);
	f.excess = 0;
	const Map<const Mat63> E(f.E);
	const double moment = E.bottomRows<3>().colwise().norm().maxCoeff(), lever = leverOf(patchOf(f));
	f.weight = E.topRows<3>().isZero(0) && moment < lever ? moment / lever : 1;
	Map<Eigen::Vector3d>(tangent(m_frictionCount++)).setZero();
}

/// Distance of the patch from the nearer of the centres of mass that it moves [m].
double btIslandBlockSolver::leverOf(const Patch& patch) const
{
	double lever = std::numeric_limits<double>::infinity();
	for (const int body : patch.body)
		if (body >= 0) lever = std::min(lever, distance(patch.point, m_bodies[size_t(body)].center));
	return lever;
}

void btIslandBlockSolver::clearFriction(const Patch& patch) { std::fill(tangent(patch.firstFriction), tangent(patch.frictionEnd), 0.0); }

int btIslandBlockSolver::addJointRow(const btIslandJointRow& row)
{
	const auto rootOf = [this](int body) { return body < 0 ? nullptr : m_bodies[size_t(body)].root; };
	m_joints.add(row, {rootOf(row.body[0]), rootOf(row.body[1])});
	return m_joints.count() - 1;
}

// The order is breadth first from the body with the fewest neighbours, and then reversed. Neighbours stay close together, and a body with
// many neighbours, such as a held one, comes after them. This keeps the envelope small.
void btIslandBlockSolver::orderBodies()
{
	m_byBody.fill(m_bodyCount, m_patchCount + m_joints.count(), [this](int k, const auto& note) {
		const int* body = bodiesOf(k);
		if (body[0] < 0 || body[1] < 0) return;
		note(body[0]);
		if (body[1] != body[0]) note(body[1]);
	});
	const auto degree = [this](int b) { return m_byBody.end(b) - m_byBody.begin(b); };
	m_order.clear();
	for (int b = 0; b < m_bodyCount; ++b) m_bodies[size_t(b)].place = -1;
	while (int(m_order.size()) < m_bodyCount)
	{
		int start = -1;
		for (int b = 0; b < m_bodyCount; ++b)
			if (m_bodies[size_t(b)].place < 0 && (start < 0 || degree(b) < degree(start))) start = b;
		size_t next = m_order.size();
		m_bodies[size_t(start)].place = int(m_order.size());
		m_order.push_back(start);
		for (; next < m_order.size(); ++next)
			for (const int* k = m_byBody.begin(m_order[next]); k != m_byBody.end(m_order[next]); ++k)
				for (int side = 0; side < 2; ++side)
				{
					const int other = bodiesOf(*k)[side];
					if (m_bodies[size_t(other)].place >= 0) continue;
					m_bodies[size_t(other)].place = int(m_order.size());
					m_order.push_back(other);
				}
	}
	std::reverse(m_order.begin(), m_order.end());
	for (int i = 0; i < m_bodyCount; ++i) m_bodies[size_t(m_order[size_t(i)])].place = i;
	m_joints.setPlaces([this](int body) { return m_bodies[size_t(body)].place; });
	if (!m_joints.isEmpty()) m_joints.setStiffness(heaviest());
	layOutFactor();
}

/// Computes the envelope. It contains the pairs of idle patches too, so that it is the same in all rounds.
void btIslandBlockSolver::layOutFactor()
{
	m_factor.begin(m_bodyCount);
	for (int k = 0; k < m_patchCount; ++k)
	{
		const Patch& p = m_patches[size_t(k)];
		if (p.body[0] >= 0 && p.body[1] >= 0) m_factor.couple(placeOf(p, 0), placeOf(p, 1));
	}
	m_joints.couple(m_factor);
	m_factor.layOut();
	m_byPlace.fill(m_bodyCount, m_frictionCount, [this](int k, const auto& note) {
		if (const int place = firstPlace(patchOf(m_frictions[size_t(k)])); place < m_bodyCount) note(place);
	});
}

/// Sets a factor to the matrix of the elastic island with its joints, before its factorisation.
void btIslandBlockSolver::assemble(btEnvelopeFactor& factor) const
{
	factor.setIdentity();
	for (int k = 0; k < m_patchCount; ++k)
	{
		const Patch& p = m_patches[size_t(k)];
		if (!p.active) continue;
		addBlocks(factor, p, [&p](int row, int column) -> Mat6 {
			return Map<const Mat6>(p.jacobian[row]).transpose() * Map<const Mat6>(p.S) * Map<const Mat6>(p.jacobian[column]);
		});
	}
	m_joints.addTo(factor);
}

bool btIslandBlockSolver::factorise()
{
	m_inverseKnown = false;
	assemble(m_factor);
	return m_factor.factorise();
}

/// Largest mass that a joint may have to hold. A stiff patch holds as if it were a mass of h^2 K + h D.
double btIslandBlockSolver::heaviest() const
{
	double largest = 0;
	for (int b = 0; b < m_bodyCount; ++b)
	{
		const double* root = m_bodies[size_t(b)].root;
		const double most = std::max({root[0], root[7], root[14]});
		if (most > 0) largest = std::max(largest, 1 / (most * most));
	}
	for (int k = 0; k < m_patchCount; ++k)
	{
		const double* S = m_patches[size_t(k)].S;
		largest = std::max({largest, S[0], S[7], S[14]});
	}
	return largest;
}

/// Finds the joint rows at their limits and refines their impulses, while the friction is fixed. Returns false when the system could not
/// be factorised.
bool btIslandBlockSolver::settleJoints()
{
	for (int k = 0; k < m_frictionCount; ++k)
		if (rubs(m_frictions[size_t(k)])) prepareAsked(m_frictions[size_t(k)]);
	m_joints.beginSearch();
	for (int refinements = 0;;)
	{
		prepareRest();
		solveElastic();
		if (m_joints.changeActiveSet(m_free.data(), m_z.data()))
		{
			if (!factorise()) return false;
		}
		else if (!m_joints.refine() || refinements++ == kMaxRefinements) return true;
	}
}

/// Refines the impulses of joints once more for what friction has changed, a thousandth of which would remain.
void btIslandBlockSolver::refineJoints()
{
	if (!m_joints.refine()) return;
	prepareRest();
	solveElastic();
	(void)m_joints.isSettled(m_free.data(), m_z.data());
}

void btIslandBlockSolver::needInverse()
{
	if (!m_inverseKnown) m_factor.invert();
	m_inverseKnown = true;
}

/// Twist of A minus that of B at the point, in the state `m_z`.
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

/// Place of the first of the patch's bodies. It is behind all places for a patch between immovable bodies.
int btIslandBlockSolver::firstPlace(const Patch& p) const
{
	int first = m_bodyCount;
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0) first = std::min(first, placeOf(p, side));
	return first;
}

/// Computes the right-hand side without friction, and the input of friction without any impulse.
void btIslandBlockSolver::prepareRest()
{
	// `m_z` must be zero, because it is the state without any impulse.
	std::fill(m_z.begin(), m_z.begin() + 6 * m_bodyCount, 0.0);
	std::fill(m_rest.begin(), m_rest.begin() + 6 * m_bodyCount, 0.0);
	m_joints.addRest(m_free.data(), m_rest.data());
	for (int k = 0; k < m_patchCount; ++k)
	{
		Patch& p = m_patches[size_t(k)];
		if (!p.active) continue;
		Vec6 u;
		relativeTwist(p, u.data());
		const Vec6 elastic = Map<const Vec6>(p.push) - Map<const Mat6>(p.S) * u;
		for (int side = 0; side < 2; ++side)
			if (p.body[side] >= 0)
				Map<Vec6>(&m_rest[6 * size_t(placeOf(p, side))]) += Map<const Mat6>(p.jacobian[side]).transpose() * elastic;
		for (int i = p.firstFriction; i < p.frictionEnd; ++i)
		{
			Friction& f = m_frictions[size_t(i)];
			Map<Eigen::Vector4d>(f.askedAtRest) << Map<const Mat63>(f.E).transpose() * u, elastic.head<3>().dot(toEigen(p.normal));
		}
	}
}

/// Sets `m_z` to the right-hand side with the friction impulses so far, after its forward substitution.
void btIslandBlockSolver::beginState()
{
	std::copy_n(m_rest.begin(), 6 * m_bodyCount, m_z.begin());
	for (int k = 0; k < m_frictionCount; ++k)
	{
		const Friction& f = m_frictions[size_t(k)];
		if (!rubs(f)) continue;
		const Patch& p = patchOf(f);
		// The push J^T E is the transpose of the derivative of the slip by the state.
		for (int side = 0; side < 2; ++side)
			if (p.body[side] >= 0)
				Map<Vec6>(&m_z[6 * size_t(placeOf(p, side))]) += Map<const Mat46>(f.asked[side]).topRows<3>().transpose() *
					Map<const Eigen::Vector3d>(tangent(k));
	}
	m_factor.substituteForward(m_z.data());
}

/// Sets `m_z` to the elastic response to the friction impulses so far.
void btIslandBlockSolver::solveElastic()
{
	beginState();
	for (int place = m_bodyCount - 1; place >= 0; --place) m_factor.substituteBack(m_z.data(), place);
}

/// True when the impulse of an idle patch would push if the patch were active. A test of the force in this state alone would bring back
/// patches that pull as soon as they act.
bool btIslandBlockSolver::wouldPush(const Patch& p)
{
	needInverse();
	Mat6 W = Mat6::Zero();
	for (int a = 0; a < 2; ++a)
		for (int b = 0; b < 2; ++b)
		{
			if (p.body[a] < 0 || p.body[b] < 0) continue;
			const int row = placeOf(p, a), column = placeOf(p, b);
			const Map<const Mat6> stored(m_factor.inverseBlock(std::max(row, column), std::min(row, column)));
			const Mat6 inverse = row >= column ? Mat6(stored) : Mat6(stored.transpose());
			W += Map<const Mat6>(p.jacobian[a]) * inverse * Map<const Mat6>(p.jacobian[b]).transpose();
			m_products += 2;
		}
	Vec6 u;
	relativeTwist(p, u.data());
	const Map<const Mat6> S(p.S);
	const Vec6 answer = (Mat6::Identity() + S * W).partialPivLu().solve(Map<const Vec6>(p.push) - S * u);
	return answer.head<3>().dot(toEigen(p.normal)) > 0;
}

/// Resistance of a patch to a motion along its normal alone.
double btIslandBlockSolver::normalStiffness(const Patch& p)
{
	const Eigen::Vector3d n = toEigen(p.normal);
	return n.dot(Map<const Mat6>(p.S).topLeftCorner<3, 3>() * n);
}

/// True when an idle patch would push as a point. A point acts along one line, so that the force in this state decides.
bool btIslandBlockSolver::isPressed(const Patch& p) const
{
	Vec6 u;
	relativeTwist(p, u.data());
	const Eigen::Vector3d n = toEigen(p.normal);
	return Map<const Vec6>(p.push).head<3>().dot(n) > normalStiffness(p) * u.head<3>().dot(n);
}

/// Leaves of the patch a point that pushes along its normal.
void btIslandBlockSolver::makePoint(Patch& p)
{
	const Eigen::Vector3d n = toEigen(p.normal);
	Map<Mat6> S(p.S);
	Map<Vec6> push(p.push);
	const double stiffness = normalStiffness(p), force = n.dot(push.head<3>());
	S.setZero();
	S.topLeftCorner<3, 3>() = stiffness * n * n.transpose();
	push << force * n, Eigen::Vector3d::Zero();
}

/// Lets an idle patch return if it would push: as it is, or else as a point. Returns false when it would not.
bool btIslandBlockSolver::letReturn(Patch& p)
{
	if (wouldPush(p)) ++p.returns;
	else if (isPressed(p)) p.returns = kReturnsOfWhole + 1;
	else return false;
	p.active = true;
	if (p.returns > kReturnsOfWhole) makePoint(p);
	return true;
}

/// Stores the elastic impulses. Returns true when a patch would pull and is removed, or when an idle one would push and returns.
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
		else if (mayReturn > 0 && letReturn(p))
		{
			changed = true;
			--mayReturn;
		}
		Map<Vec6>(p.elastic).setZero();
		clearFriction(p);
	}
	return changed;
}

void btIslandBlockSolver::setZero()
{
	for (int k = 0; k < m_patchCount; ++k)
	{
		Map<Vec6>(m_patches[size_t(k)].elastic).setZero();
		clearFriction(m_patches[size_t(k)]);
	}
	m_joints.setZero();
}

bool btIslandBlockSolver::solve(const ist::Twist* free)
{
	reserve(m_bodyCount, m_patchCount);
	for (int b = 0; b < m_bodyCount; ++b)
	{
		Map<Vec6> twist(&m_free[6 * size_t(b)]);
		twist = toEigen(free[b].linear, free[b].angular);
	}
	m_frictionNotConverged = m_activeSetNotFound = false;
	m_sweeps = m_frictionSteps = 0;
	m_remainingChange = 0;
	m_productsBefore = allProducts();
	const bool hasJoints = !m_joints.isEmpty();
	m_rounds = 0;
	for (int searches = 0;;)
	{
		if (!m_frictionPrepared)
		{
			if (m_rounds == 0) orderBodies();
			if (!factorise() || (hasJoints && !settleJoints()))
			{
				setZero();
				return false;
			}
			prepareFriction();
		}
		prepareRest();
		if (m_hasFriction) iterateFriction();
		else solveElastic();
		const int mayReturn = m_rounds < kRoundsOfAll ? m_patchCount : m_rounds < kRoundsOfAll + kRoundsOfOne ? 1 : 0;
		const bool settled = !hasJoints || m_joints.isSettled(m_free.data(), m_z.data()) || searches++ >= kMaxSearches;
		if (settled && hasJoints) refineJoints();
		if (settled && !changeActiveSet(mayReturn))
		{
			m_activeSetNotFound = mayReturn == 0 &&
				std::any_of(m_patches.begin(), m_patches.begin() + m_patchCount,
					[this](const Patch& p) { return !p.active && (wouldPush(p) || isPressed(p)); });
			return true;
		}
		m_frictionPrepared = false;
		++m_rounds;
	}
}

ist::Wrench btIslandBlockSolver::impulse(int patch) const
{
	const Patch& p = m_patches[size_t(patch)];
	Vec6 total = Map<const Vec6>(p.elastic);
	for (int k = p.firstFriction; k < p.frictionEnd; ++k)
		total += Map<const Mat63>(m_frictions[size_t(k)].E) * Map<const Eigen::Vector3d>(tangent(k));
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
