// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btIslandBlockMatrices.h"
#include "BulletHapticForce/Solver/btIslandBlockSolver.h"
#include "BulletHapticForce/Solver/btToEigen.h"

#include <algorithm>
#include <cmath>
#include <iterator>

// Newton's method for all friction of an island at once (P. Alart and A. Curnier, A mixed formulation for frictional contact
// problems prone to Newton like solution methods, 1991).
//
// Friction t obeys Coulomb's law where t = P(t - r s), with the slip s along E and the projection P onto the ball of the limit. r is a
// multiple of the inverse of the slip per impulse, so that the error of a patch that sticks is its slip. Each step solves the equations
// with the derivative D of P, the identity where a patch sticks:
//   (1 + g) dt - D (dt - r ds) = P(t - r s) - t,  or  dt = step - W ds.
// g, a small number, keeps the friction of patches that share a load determined. W is a damper, so that one factor of the elastic island
// with these dampers gives the step of the state, and that the step of all friction. The change of the limit with the state is left out of
// D, which keeps the factor symmetric; the error contains it.

using namespace btIslandBlockMatrices;
using namespace btToEigen;

namespace
{
// r over the inverse of the largest slip per impulse, in the first search and in the next ones, which begin again at the first. Small ones
// find the patches that slide, large ones what sticks where a body moves 10,000 times as easily by itself as with the others.
constexpr double kFirmness[] = {300, 9e3, 2.7e5};
constexpr double kGive = 1e-2;  // g
constexpr int kMaxSteps = 6, kMaxHalvings = 5;
constexpr double kSufficient = 1e-3;  // part of the error that a whole step must take away
// A search ends at this share of the tolerance of the sweeps, which decide.
constexpr double kEnough = 0.1;
}  // namespace

btIslandBlockSolver::FrictionError btIslandBlockSolver::frictionError(int friction) const
{
	const Friction& f = m_frictions[size_t(friction)];
	FrictionError error{{0, 0, 0}, {0, 0, 0}, 1};
	Eigen::Vector4d asked;
	ask(f, asked.data());
	const Map<const Eigen::Vector3d> now(tangent(friction));
	const Eigen::Vector3d sticking = now - m_firmness / f.mostYielding * asked.head<3>();
	const double limit = f.coefficient * std::max(asked(3), 0.0), length = sticking.norm();
	if (length > limit)
	{
		error.share = limit / length;
		Map<Eigen::Vector3d>(error.direction) = sticking / length;
	}
	Map<Eigen::Vector3d>(error.missing) = error.share * sticking - now;
	return error;
}

/// Root of the sum of the squares of all errors, weighed [N s].
double btIslandBlockSolver::totalFrictionError() const
{
	double squares = 0;
	for (int k = 0; k < m_frictionCount; ++k)
		if (yields(m_frictions[size_t(k)]))
			squares += (m_frictions[size_t(k)].weight * Map<const Eigen::Vector3d>(frictionError(k).missing)).squaredNorm();
	return std::sqrt(squares);
}

/// Computes the ball's step without a step of the slip, and its damper, and adds both to the equations of the state's step.
void btIslandBlockSolver::prepareStep(int friction)
{
	Friction& f = m_frictions[size_t(friction)];
	const Patch& p = patchOf(f);
	const FrictionError error = frictionError(friction);
	const Map<const Eigen::Vector3d> missing(error.missing), direction(error.direction);
	// Across the direction of sliding, D is `share`; along it, it is 0. Where the ball sticks, there is no such direction.
	const double across = 1 / (1 + kGive - error.share);
	Map<Eigen::Vector3d> step(f.step);
	Map<Axes> resistance(f.resistance);
	step = across * missing + (1 / (1 + kGive) - across) * direction.dot(missing) * direction;
	resistance = m_firmness / f.mostYielding * error.share * across * (Axes::Identity() - direction * direction.transpose());
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0)
			Map<Vec6>(&m_stateStep[6 * size_t(placeOf(p, side))]) += Map<const Mat46>(f.asked[side]).topRows<3>().transpose() * step;
	addBlocks(m_stuckFactor, p, [&](int row, int column) -> Mat6 {
		return Map<const Mat46>(f.asked[row]).topRows<3>().transpose() * resistance * Map<const Mat46>(f.asked[column]).topRows<3>();
	});
}

/// Takes from the ball's step what the step of the slip takes from it.
void btIslandBlockSolver::finishStep(int friction)
{
	Friction& f = m_frictions[size_t(friction)];
	const Patch& p = patchOf(f);
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0)
			Map<Eigen::Vector3d>(f.step) -= Map<const Axes>(f.resistance) *
				(Map<const Mat46>(f.asked[side]).topRows<3>() * Map<const Vec6>(&m_stateStep[6 * size_t(placeOf(p, side))]));
}

/// Makes one step from the state `m_z`, whose error is given. Halves it until the error falls; returns false when it does not, and leaves
/// friction as it was. The error afterwards is stored.
bool btIslandBlockSolver::stepFriction(double& error)
{
	assemble(m_stuckFactor);
	std::fill_n(m_stateStep.begin(), 6 * m_bodyCount, 0.0);
	for (int k = 0; k < m_frictionCount; ++k)
		if (yields(m_frictions[size_t(k)])) prepareStep(k);
	++m_frictionSteps;
	if (!m_stuckFactor.factorise()) return false;
	m_stuckFactor.solve(m_stateStep.data());
	for (int k = 0; k < m_frictionCount; ++k)
		if (yields(m_frictions[size_t(k)])) finishStep(k);
	std::copy_n(m_tangents.begin(), 3 * m_frictionCount, m_tangentsBefore.begin());
	double share = 1;
	for (int halvings = 0; halvings <= kMaxHalvings; ++halvings, share /= 2)
	{
		for (int k = 0; k < m_frictionCount; ++k)
			if (yields(m_frictions[size_t(k)]))
				Map<Eigen::Vector3d>(tangent(k)) = Map<const Eigen::Vector3d>(&m_tangentsBefore[3 * size_t(k)]) +
					share * Map<const Eigen::Vector3d>(m_frictions[size_t(k)].step);
		solveElastic();
		if (const double now = totalFrictionError(); now < (1 - kSufficient * share) * error)
		{
			error = now;
			return true;
		}
	}
	std::copy_n(m_tangentsBefore.begin(), 3 * m_frictionCount, m_tangents.begin());
	return false;
}

/// Makes steps until the error is well below the tolerance [N s], or no longer falls. `search` is the number of searches before.
void btIslandBlockSolver::searchFriction(double tolerance, int search)
{
	m_firmness = kFirmness[size_t(search) % std::size(kFirmness)];
	m_stuckFactor.layOutAs(m_factor);
	solveElastic();
	double error = totalFrictionError();
	for (int steps = 0; steps < kMaxSteps && error > kEnough * tolerance; ++steps)
		if (!stepFriction(error)) return;
}
