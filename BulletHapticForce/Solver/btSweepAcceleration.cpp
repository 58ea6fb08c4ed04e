// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btSweepAcceleration.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>

namespace
{
/// Regularisation as a share of the products' diagonal, because steps may point in the same direction.
constexpr double kRegularisation = 1e-10;
/// Largest motion of x, in lengths of the last change. A larger motion would consist of rounding errors.
constexpr double kLongest = 1e4;

using Column = Eigen::Map<Eigen::VectorXd>;
using ConstColumn = Eigen::Map<const Eigen::VectorXd>;
}  // namespace

void btSweepAcceleration::reserve(std::size_t unknowns)
{
	const auto grow = [](std::vector<double>& column, std::size_t size) { column.resize(std::max(column.size(), size)); };
	for (auto* column : {&m_start, &m_change, &m_result}) grow(*column, unknowns);
	for (auto* steps : {m_changeStep, m_resultStep})
		for (int i = 0; i < kDepth; ++i) grow(steps[i], unknowns);
}

void btSweepAcceleration::begin(const double* x, std::size_t unknowns)
{
	reserve(unknowns);
	m_unknowns = unknowns;
	m_sweeps = 0;
	std::copy_n(x, unknowns, m_start.begin());
}

void btSweepAcceleration::note(const double* x)
{
	const Eigen::Index n = Eigen::Index(m_unknowns);
	const int to = (m_sweeps + kDepth - 1) % kDepth;  // the first sweep has no sweep before it, and its step is never used
	Column changeStep(m_changeStep[to].data(), n), change(m_change.data(), n), resultStep(m_resultStep[to].data(), n),
		result(m_result.data(), n);
	const double before = m_sweeps > 0 ? change.norm() : 0;
	changeStep = ConstColumn(x, n) - ConstColumn(m_start.data(), n) - change;
	change += changeStep;
	const bool farther = m_sweeps > 0 && change.norm() > before;
	resultStep = ConstColumn(x, n) - result;
	result += resultStep;
	m_sweeps = farther ? 1 : m_sweeps + 1;  // the former steps no longer help
	const int steps = std::min(m_sweeps - 1, kDepth);
	for (int i = 0; i < steps; ++i) m_products[to][i] = m_products[i][to] = changeStep.dot(Column(m_changeStep[i].data(), n));
}

void btSweepAcceleration::weigh(double* weights, int steps) const
{
	using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kDepth, kDepth>;
	using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kDepth, 1>;
	Small products(steps, steps);
	SmallVector right(steps);
	const ConstColumn change(m_change.data(), Eigen::Index(m_unknowns));
	for (int i = 0; i < steps; ++i)
	{
		right(i) = change.dot(ConstColumn(m_changeStep[i].data(), change.size()));
		for (int j = 0; j < steps; ++j) products(i, j) = m_products[i][j];
		products(i, i) *= 1 + kRegularisation;
	}
	Eigen::Map<SmallVector>(weights, steps) = products.ldlt().solve(right);
}

void btSweepAcceleration::advance(double* x)
{
	note(x);
	const int steps = std::min(m_sweeps - 1, kDepth);
	const Eigen::Index n = Eigen::Index(m_unknowns);
	double weights[kDepth] = {};
	if (steps > 0) weigh(weights, steps);
	Column start(m_start.data(), n), end(x, n);
	start = end;
	for (int i = 0; i < steps; ++i) start -= weights[i] * Column(m_resultStep[i].data(), n);
	// If the steps contain no information, the weights may not be finite.
	if (!((start - end).norm() <= kLongest * Column(m_change.data(), n).norm())) start = end;
	end = start;
}
