// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btIslandJoints.h"

#include <algorithm>
#include <cmath>

namespace
{
constexpr int kSide = btEnvelopeFactor::kSide;
// The stiffness of a damper, in units of the heaviest mass: one solve leaves about a thousandth of the load to the next refinement.
constexpr double kStiffness = 1e3;
// A larger product of stiffness and response would cost digits of the factor.
constexpr double kStiffest = 1e9;
// The search moves all rows at once until this many rounds have not reduced the number of rows that are in the wrong state.
constexpr int kPatience = 3;
constexpr int kMaxRounds = 60;
constexpr double kRefined = 1e-6;  // share of the largest impulse

double product(const double* a, const double* b)
{
	double sum = 0;
	for (int i = 0; i < kSide; ++i) sum += a[i] * b[i];
	return sum;
}
}  // namespace

void btIslandJoints::add(const btIslandJointRow& given, const double* const (&roots)[2])
{
	Row row;
	row.given = given;
	for (int side = 0; side < 2; ++side)
	{
		if (given.body[side] < 0) continue;
		const double* root = roots[side];
		// The root is symmetric.
		for (int i = 0; i < kSide; ++i) row.jacobian[side][i] = product(root + kSide * i, given.jacobian[side]);
		row.response += product(row.jacobian[side], row.jacobian[side]);
		const double largest = std::max({root[0], root[7], root[14]});
		if (largest > 0) row.lightest = row.lightest > 0 ? std::min(row.lightest, 1 / (largest * largest)) : 1 / (largest * largest);
	}
	m_rows.push_back(row);
}

void btIslandJoints::setStiffness(double heaviest)
{
	for (Row& r : m_rows)
	{
		const double ratio = r.lightest > 0 ? std::max(heaviest / r.lightest, 1.0) : 1;
		r.stiffness = r.response > 0 ? std::min(kStiffness * ratio, kStiffest) / r.response : 0;
	}
}

void btIslandJoints::couple(btEnvelopeFactor& factor) const
{
	for (const Row& r : m_rows)
		if (r.place[0] >= 0 && r.place[1] >= 0) factor.couple(r.place[0], r.place[1]);
}

void btIslandJoints::addTo(btEnvelopeFactor& factor) const
{
	double block[btEnvelopeFactor::kBlock];
	for (const Row& r : m_rows)
	{
		if (r.state != State::Free) continue;
		for (int row = 0; row < 2; ++row)
			for (int column = 0; column < 2; ++column)
			{
				if (r.place[row] < 0 || r.place[column] < 0 || r.place[row] < r.place[column]) continue;
				for (int i = 0; i < kSide; ++i)
					for (int j = 0; j < kSide; ++j)
						block[kSide * i + j] = r.stiffness * r.softening() * r.jacobian[row][i] * r.jacobian[column][j];
				factor.add(r.place[row], r.place[column], block);
			}
	}
}

/// Velocity of the row without any impulse of the island.
double btIslandJoints::velocity(const Row& r, const double* free)
{
	double sum = 0;
	for (int side = 0; side < 2; ++side)
		if (r.given.body[side] >= 0) sum += product(r.given.jacobian[side], free + kSide * r.given.body[side]);
	return sum;
}

void btIslandJoints::addRest(const double* free, double* rest) const
{
	for (const Row& r : m_rows)
	{
		const double push = r.state == State::Free ? (r.former + r.stiffness * (r.given.wanted - velocity(r, free))) * r.softening()
												   : r.limit();
		for (int side = 0; side < 2; ++side)
			for (int i = 0; r.place[side] >= 0 && i < kSide; ++i) rest[kSide * r.place[side] + i] += push * r.jacobian[side][i];
	}
}

double btIslandJoints::Row::limit() const
{
	if (state == State::Lower) return given.lower;
	return state == State::Upper ? given.upper : std::clamp(0.0, given.lower, given.upper);
}

btIslandJoints::State btIslandJoints::aim(Row& r, const double* free, const double* z)
{
	double now = velocity(r, free);
	for (int side = 0; side < 2; ++side)
		if (r.place[side] >= 0) now += product(r.jacobian[side], z + kSide * r.place[side]);
	const double aim = (r.former + r.stiffness * (r.given.wanted - now)) * r.softening();
	r.impulse = r.state == State::Free ? std::clamp(aim, r.given.lower, r.given.upper) : r.limit();
	// A row without a range, such as that of a motor without force, needs no state but one.
	if (!(r.given.lower < r.given.upper)) return State::Lower;
	return aim < r.given.lower ? State::Lower : aim > r.given.upper ? State::Upper : State::Free;
}

void btIslandJoints::beginSearch()
{
	m_fewest = count() + 1;
	m_patience = kPatience;
	m_rounds = 0;
	for (Row& r : m_rows)
		if (r.state == State::Idle) r.state = State::Free;
}

bool btIslandJoints::changeActiveSet(const double* free, const double* z)
{
	Row* last = nullptr;
	int wrong = 0;
	for (Row& r : m_rows)
		if (r.state != State::Idle && aim(r, free, z) != r.state)
		{
			last = &r;
			++wrong;
		}
	if (wrong == 0) return false;
	if (wrong < m_fewest) m_patience = kPatience;
	m_fewest = std::min(m_fewest, wrong);
	const bool isLost = ++m_rounds > kMaxRounds;
	if (--m_patience < 0 && !isLost)
	{
		last->state = last->state == State::Free ? aim(*last, free, z) : State::Free;
		return true;
	}
	for (Row& r : m_rows)
	{
		if (r.state == State::Idle) continue;
		const State next = aim(r, free, z);
		if (next != r.state) r.state = isLost ? State::Idle : next;
	}
	return true;
}

bool btIslandJoints::isSettled(const double* free, const double* z)
{
	bool settled = true;
	for (Row& r : m_rows)
	{
		const State next = aim(r, free, z);
		settled = settled && (r.state == State::Idle || next == r.state);
	}
	return settled;
}

bool btIslandJoints::refine()
{
	m_fewest = count() + 1;
	m_patience = kPatience;
	double change = 0, largest = 0;
	for (Row& r : m_rows)
	{
		if (r.state == State::Free) change = std::max(change, std::fabs(r.impulse - r.former));
		largest = std::max(largest, std::fabs(r.impulse));
		r.former = r.impulse;
	}
	return change > kRefined * largest;
}

void btIslandJoints::setZero()
{
	for (Row& r : m_rows) r.impulse = r.former = 0;
}
