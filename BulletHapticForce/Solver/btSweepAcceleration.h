// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <vector>

/// Anderson acceleration of sweeps x -> g(x) that converge slowly along a few directions. It takes the combination of the last sweeps
/// whose changes g(x) - x cancel best. It starts again after a sweep with a larger change than the one before. If x must obey limits,
/// only a sweep enforces them, so the last operation should be a sweep. Allocates nothing once `reserve` has seen the size.
class btSweepAcceleration
{
public:
	void reserve(std::size_t unknowns);
	/// Begins an iteration; `x` is the start of the first sweep.
	void begin(const double* x, std::size_t unknowns);
	/// Call this after a sweep, with its result: moves `x` to the start of the next sweep.
	void advance(double* x);

private:
	static constexpr int kDepth = 4;  ///< number of sweeps that are combined with the last one

	/// Stores the difference between the last sweep and the one before, in place of the oldest such difference ("step").
	void note(const double* x);
	/// Computes the share of each step that is taken back.
	void weigh(double* weights, int steps) const;

	std::size_t m_unknowns = 0;
	std::vector<double> m_start;             // x before the sweep
	std::vector<double> m_change, m_result;  // g(x) - x and g(x) of the last sweep
	std::vector<double> m_changeStep[kDepth], m_resultStep[kDepth];
	double m_products[kDepth][kDepth] = {};  // products of the steps of the change
	int m_sweeps = 0;
};
