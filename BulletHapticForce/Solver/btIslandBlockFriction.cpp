// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btFrictionWithinLimit.h"
#include "BulletHapticForce/Solver/btIslandBlockMatrices.h"
#include "BulletHapticForce/Solver/btIslandBlockSolver.h"
#include "BulletHapticForce/Solver/btToEigen.h"
#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <algorithm>

// The friction of an island's patches.

using namespace btIslandBlockMatrices;
using namespace btToEigen;

namespace
{
constexpr int kMaxSweeps = 400;
// Where many patches share one load, sweeps get on by 1e-3 of the error and less. If kPatience sweeps have not reduced the change to the
// share kProgress, Newton's method takes over. A few sweeps after it bring it over the kinks between sticking and sliding. Of 12,000
// solves for sixteen bodies that fall into bins, 400 needed more searches; the next step begins with their remaining error.
constexpr int kPatience = 24, kSweepsAfterSearch = 8, kMaxSearches = 6;
constexpr double kProgress = 0.5;
// Friction has converged when no impulse changes by more than this share of the largest normal impulse, as `remainingChange` counts it:
// about a rounding of single precision. A sticking body then creeps by at most this share of g h, because the next step begins where this
// one ends.
constexpr double kFrictionTolerance = 1e-7;
// If the sweeps end early, friction beyond its limit is cut down. This changes the normal impulses, which are then computed again. Later
// cuts go further below the limit, and after this number to zero. The cuts end, because a patch without friction is not cut again.
constexpr int kCutsToNothing = 50;
constexpr double kImmovable = 1e-12;
}  // namespace

void btIslandBlockSolver::startFriction(int patch, const ist::Wrench& impulse)
{
	const Patch& p = m_patches[size_t(patch)];
	Vec6 left = toEigen(impulse.force, impulse.torque);
	for (int k = p.firstFriction; k < p.frictionEnd; ++k)
	{
		const Map<const Mat63> E(m_frictions[size_t(k)].E);
		for (int i = 0; i < 3; ++i)
		{
			const double square = E.col(i).squaredNorm();
			tangent(k)[i] = square > 0 ? E.col(i).dot(left) / square : 0;
			left -= tangent(k)[i] * E.col(i);
		}
	}
}

/// Computes the derivative of the slip and of the elastic normal impulse by the state, for each body of the patch.
void btIslandBlockSolver::prepareAsked(Friction& f) const
{
	const Patch& p = patchOf(f);
	Mat46 ofTwist;
	ofTwist << Map<const Mat63>(f.E).transpose(), -toEigen(p.normal).transpose() * Map<const Mat6>(p.S).topRows<3>();
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0) Map<Mat46>(f.asked[side]) = ofTwist * Map<const Mat6>(p.jacobian[side]);
}

void btIslandBlockSolver::prepareFriction()
{
	m_response.clear();
	m_hasFriction = false;
	for (int k = 0; k < m_frictionCount; ++k)
	{
		Friction& f = m_frictions[size_t(k)];
		if (!rubs(f)) continue;
		m_hasFriction = true;
		needInverse();
		prepareAsked(f);
		double slip[9], yielding[3][3];
		prepareResponse(f, slip);
		const Map<const Axes> G(slip);
		Map<Axes> symmetric(yielding[0]);
		symmetric = 0.5 * (G + G.transpose());
		ist::SymmetricEigen<3> eigen;
		if (!eigen.decompose(yielding)) eigen = {};  // not finite: no friction
		Map<Axes>(f.axes) = Map<const Axes>(eigen.vectors[0]);
		const Map<const Eigen::Vector3d> values(eigen.values);
		f.mostYielding = values.maxCoeff();
		Map<Eigen::Vector3d>(f.yielding) = (values.array() > kImmovable * f.mostYielding).select(values, 0.0);
	}
	m_frictionPrepared = true;
}

/// Stores the response of the clique of the patch to its friction. `slip` is the response of its own slip.
void btIslandBlockSolver::prepareResponse(Friction& f, double (&slip)[9])
{
	const Patch& p = patchOf(f);
	f.response = m_response.size();
	const int first = firstPlace(p), count = first < m_bodyCount ? 1 + int(m_factor.cliqueEnd(first) - m_factor.cliqueBegin(first)) : 0;
	m_response.resize(m_response.size() + 18 * size_t(count));
	Map<Axes> G(slip);
	G.setZero();
	for (int i = 0; i < count; ++i)
	{
		const int place = i == 0 ? first : m_factor.cliqueBegin(first)[i - 1];
		Map<Mat63> answer(&m_response[f.response + 18 * size_t(i)]);
		answer.setZero();
		for (int side = 0; side < 2; ++side)
		{
			if (p.body[side] < 0) continue;
			const auto push = Map<const Mat46>(f.asked[side]).topRows<3>().transpose();
			const int from = placeOf(p, side);
			if (place >= from) answer += Map<const Mat6>(m_factor.inverseBlock(place, from)) * push;
			else answer += Map<const Mat6>(m_factor.inverseBlock(from, place)).transpose() * push;
			++m_products;
		}
		for (int side = 0; side < 2; ++side)
			if (p.body[side] >= 0 && placeOf(p, side) == place) G += Map<const Mat46>(f.asked[side]).topRows<3>() * answer;
	}
}

/// Computes what friction depends on in the state `m_z`: the slip along E, and the elastic normal impulse.
void btIslandBlockSolver::ask(const Friction& f, double* asked) const
{
	const Patch& p = patchOf(f);
	Map<Eigen::Vector4d> sum(asked);
	sum = Map<const Eigen::Vector4d>(f.askedAtRest);
	for (int side = 0; side < 2; ++side)
		if (p.body[side] >= 0) sum += Map<const Mat46>(f.asked[side]) * Map<const Vec6>(&m_z[6 * size_t(placeOf(p, side))]);
}

/// Visits one ball while the others are fixed, and updates the state of its clique. Returns the change of its friction as
/// `remainingChange` counts it; `normal` is the present normal impulse of its patch.
double btIslandBlockSolver::visitFriction(int friction, int place, double& normal)
{
	Friction& f = m_frictions[size_t(friction)];
	Eigen::Vector4d asked;
	ask(f, asked.data());
	normal = std::max(asked(3), 0.0);
	Map<Eigen::Vector3d> now(tangent(friction));
	const Map<const Axes> axes(f.axes);
	const Eigen::Vector3d before = axes * now,
						  wanted = btFrictionWithinLimit(f.coefficient * normal, before, axes * asked.head<3>(), f.yielding, f.excess),
						  change = axes.transpose() * wanted - now;
	now += change;
	if (change.isZero(0)) return 0;
	const double* response = &m_response[f.response];
	const auto move = [&](int member) {
		Map<Vec6>(&m_z[6 * size_t(member)]) += Map<const Mat63>(response) * change;
		response += 18;
	};
	move(place);
	for (const int* later = m_factor.cliqueBegin(place); later != m_factor.cliqueEnd(place); ++later) move(*later);
	m_products += uint64_t(m_factor.cliqueEnd(place) - m_factor.cliqueBegin(place)) + 1;
	return f.mostYielding > 0 ? f.weight * Map<const Eigen::Vector3d>(f.yielding).cwiseProduct(wanted - before).norm() / f.mostYielding : 0;
}

/// Makes one sweep, which is one substitution. During the back substitution, the friction of a body is visited as soon as its state is
/// known. The change that their friction makes in the clique is all that the earlier bodies need. The later bodies receive it in the next
/// sweep.
double btIslandBlockSolver::sweep(double& largestNormal)
{
	beginState();
	double largest = 0;
	for (int place = m_bodyCount - 1; place >= 0; --place)
	{
		m_factor.substituteBack(m_z.data(), place);
		for (const int* k = m_byPlace.begin(place); k != m_byPlace.end(place); ++k)
		{
			if (!rubs(m_frictions[size_t(*k)])) continue;
			double normal = 0;
			largest = std::max(largest, visitFriction(*k, place, normal));
			largestNormal = std::max(largestNormal, normal);
		}
	}
	return largest;
}

/// Sweeps and searches by Newton's method in turn, until friction converges.
void btIslandBlockSolver::iterateFriction()
{
	double largestNormal = 0, before = 0;
	int searches = 0, sweeps = 0;  // sweeps since the last search
	m_acceleration.begin(m_tangents.data(), 3 * size_t(m_frictionCount));
	for (m_sweeps = 0; m_sweeps < kMaxSweeps; ++m_sweeps)
	{
		m_remainingChange = sweep(largestNormal);
		m_frictionNotConverged = m_remainingChange > kFrictionTolerance * largestNormal;
		if (!m_frictionNotConverged || m_sweeps == kMaxSweeps - 1) break;
		++sweeps;
		bool stalls = searches > 0 && sweeps == kSweepsAfterSearch;
		if (searches == 0 && sweeps % kPatience == 0)
		{
			stalls = sweeps > kPatience && m_remainingChange > kProgress * before;
			before = m_remainingChange;
		}
		if (!stalls)
		{
			m_acceleration.advance(m_tangents.data());
			continue;
		}
		if (searches == kMaxSearches) break;
		searchFriction(kFrictionTolerance * largestNormal, searches++);
		m_acceleration.begin(m_tangents.data(), 3 * size_t(m_frictionCount));
		largestNormal = sweeps = 0;
	}
	solveElastic();
	if (!m_frictionNotConverged) return;
	for (int i = 0; cutFriction(kFrictionTolerance * largestNormal, std::max(1 - double(i) / kCutsToNothing, 0.0)); ++i) solveElastic();
}

/// Cuts friction that exceeds its limit by more than `tolerance` [N s] to `share` of the limit. The limit is that of the normal impulse
/// in this state. Returns true when it has cut any.
bool btIslandBlockSolver::cutFriction(double tolerance, double share)
{
	bool cut = false;
	for (int k = 0; k < m_frictionCount; ++k)
	{
		const Friction& f = m_frictions[size_t(k)];
		if (!rubs(f)) continue;
		Eigen::Vector4d asked;
		ask(f, asked.data());
		const double limit = f.coefficient * std::max(asked(3), 0.0);
		Map<Eigen::Vector3d> friction(tangent(k));
		const double length = friction.norm();
		if (!(length > limit + tolerance)) continue;
		friction *= share * limit / length;
		cut = true;
	}
	return cut;
}
