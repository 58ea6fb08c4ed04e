// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <vector>

/// Anderson acceleration of sweeps x -> g(x) that creep along a few directions: of the last ones it takes the combination whose changes
/// g(x) - x cancel best, until one changes more than the one before. If x must obey limits, the next sweep sees to them, so that one should
/// be the last. No allocation once `reserve` has seen the size.
class btSweepAcceleration
{
public:
	void reserve(std::size_t unknowns);
	/// `x`: where the first sweep begins.
	void begin(const double* x, std::size_t unknowns);
	/// After a sweep, with what it left: moves `x` to where the next one should begin.
	void advance(double* x);

private:
	static constexpr int kDepth = 4;  ///< sweeps that are combined with the last one

	/// What the last sweep did differently from the one before, in place of the oldest such step.
	void note(const double* x);
	/// How much of each step to take back.
	void weigh(double* weights, int steps) const;

	std::size_t m_unknowns = 0;
	std::vector<double> m_start;             // x before the sweep
	std::vector<double> m_change, m_result;  // of the last sweep: g(x) - x, and g(x)
	std::vector<double> m_changeStep[kDepth], m_resultStep[kDepth];
	double m_products[kDepth][kDepth] = {};  // of the steps of the change
	int m_sweeps = 0;
};
