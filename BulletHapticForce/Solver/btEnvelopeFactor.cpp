// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btEnvelopeFactor.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace
{
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;
template <class M> using Map = Eigen::Map<M>;
/// A block of the factor. The distance between its rows is the width of the row of blocks.
using Block = Eigen::Map<const Mat6, 0, Eigen::OuterStride<>>;
}  // namespace

void btEnvelopeFactor::reserve(int places)
{
	const size_t n = size_t(places), blocks = n * (n + 1) / 2;
	m_first.reserve(n);
	m_row.reserve(n);
	m_cliques.reserve(n, blocks);
	m_factor.reserve(blocks * kBlock);
	m_inverse.reserve(blocks * kBlock);
	m_quotients.reserve(n * kBlock);
}

void btEnvelopeFactor::begin(int places)
{
	m_places = places;
	m_first.resize(size_t(places));
	for (int i = 0; i < places; ++i) m_first[size_t(i)] = i;
}

void btEnvelopeFactor::couple(int a, int b)
{
	int& first = m_first[size_t(std::max(a, b))];
	first = std::min(first, std::min(a, b));
}

void btEnvelopeFactor::layOut()
{
	m_row.resize(size_t(m_places));
	m_size = 0;
	for (int row = 0; row < m_places; ++row)
	{
		m_row[size_t(row)] = m_size;
		m_size += size_t(kSide) * size_t(width(row));
	}
	m_cliques.fill(m_places, m_places, [this](int row, const auto& note) {
		for (int column = m_first[size_t(row)]; column < row; ++column) note(column);
	});
}

void btEnvelopeFactor::layOutAs(const btEnvelopeFactor& other)
{
	m_places = other.m_places;
	m_first = other.m_first;
	m_row = other.m_row;
	m_cliques = other.m_cliques;
	m_size = other.m_size;
}

int64_t btEnvelopeFactor::entries() const
{
	int64_t entries = 0;
	for (int place = 0; place < m_places; ++place) entries += kSide * (width(place) - kSide) + kSide * (kSide + 1) / 2;
	return entries;
}

void btEnvelopeFactor::setIdentity()
{
	m_factor.assign(m_size, 0.0);
	for (int place = 0; place < m_places; ++place)
		for (int i = 0; i < kSide; ++i) m_factor[rowOf(place) + size_t((i + 1) * width(place) - kSide + i)] = 1;
}

void btEnvelopeFactor::add(int row, int column, const double* block)
{
	Eigen::Map<Mat6, 0, Eigen::OuterStride<>> to(
		m_factor.data() + rowOf(row) + kSide * (column - m_first[size_t(row)]), Eigen::OuterStride<>(width(row)));
	to += Map<const Mat6>(block);
}

bool btEnvelopeFactor::factorise()
{
	for (int place = 0; place < m_places; ++place)
	{
		const int first = kSide * m_first[size_t(place)];
		for (int i = 0; i < kSide; ++i)
		{
			double* rowI = m_factor.data() + rowOf(place) + i * width(place);
			for (int j = first; j <= kSide * place + i; ++j)
			{
				const int other = j / kSide, firstOfOther = kSide * m_first[size_t(other)], from = std::max(first, firstOfOther);
				const double* rowJ = m_factor.data() + rowOf(other) + (j % kSide) * width(other) - firstOfOther;
				const double rest = rowI[j - first] -
					Map<const Vector>(rowI + from - first, j - from).dot(Map<const Vector>(rowJ + from, j - from));
				if (kSide * place + i == j && !(rest > 0)) return false;
				rowI[j - first] = kSide * place + i == j ? 1 / std::sqrt(rest) : rest * rowJ[j];
			}
		}
		for (int column = m_first[size_t(place)]; column <= place; ++column)
			m_products += uint64_t(column - std::max(m_first[size_t(place)], m_first[size_t(column)]) + 1);
	}
	return true;
}

// Takahashi's recursion: it follows from Z L = L^-T, block by block from the last column to the first.
void btEnvelopeFactor::invert()
{
	m_inverse.resize(m_size);
	m_quotients.resize(size_t(m_places) * kBlock);
	for (int place = m_places - 1; place >= 0; --place)
	{
		const Block factor(factorBlock(place, place), Eigen::OuterStride<>(width(place)));
		Mat6 root = Mat6::Zero();  // L_bb^-1
		for (int i = 0; i < kSide; ++i)
			for (int j = 0; j <= i; ++j)
			{
				double rest = i == j ? 1 : 0;
				for (int k = j; k < i; ++k) rest -= factor(i, k) * root(k, j);
				root(i, j) = factor(i, i) * rest;
			}
		const int *begin = cliqueBegin(place), count = int(cliqueEnd(place) - begin);
		for (int q = 0; q < count; ++q)
			Map<Mat6>(m_quotients.data() + kBlock * q).noalias() =
				Block(factorBlock(begin[q], place), Eigen::OuterStride<>(width(begin[q]))) * root;
		Mat6 diagonal = root.transpose() * root;
		for (int m = 0; m < count; ++m)
		{
			Map<Mat6> found(m_inverse.data() + blockOf(begin[m], place));
			found.setZero();
			for (int q = 0; q < count; ++q)
			{
				const Map<const Mat6> quotient(m_quotients.data() + kBlock * q);
				if (m >= q) found.noalias() -= Map<const Mat6>(inverseBlock(begin[m], begin[q])) * quotient;
				else found.noalias() -= Map<const Mat6>(inverseBlock(begin[q], begin[m])).transpose() * quotient;
			}
			diagonal.noalias() -= found.transpose() * Map<const Mat6>(m_quotients.data() + kBlock * m);
		}
		Map<Mat6>(m_inverse.data() + blockOf(place, place)) = 0.5 * (diagonal + diagonal.transpose());
		m_products += uint64_t(count) * uint64_t(count + 2) + 1;
	}
}

void btEnvelopeFactor::substituteForward(double* x)
{
	for (int place = 0; place < m_places; ++place)
	{
		const int first = kSide * m_first[size_t(place)];
		for (int i = 0; i < kSide; ++i)
		{
			const int length = kSide * place + i - first;
			const double* row = m_factor.data() + rowOf(place) + i * width(place);
			double& own = x[kSide * place + i];
			own = row[length] * (own - Map<const Vector>(row, length).dot(Map<const Vector>(x + first, length)));
		}
	}
	m_products += uint64_t(blocks());
}

void btEnvelopeFactor::substituteBack(double* x, int place)
{
	Map<Vec6> own(x + kSide * place);
	for (const int* later = cliqueBegin(place); later != cliqueEnd(place); ++later)
	{
		const Block block(factorBlock(*later, place), Eigen::OuterStride<>(width(*later)));
		for (int i = 0; i < kSide; ++i) own -= x[kSide * *later + i] * block.row(i).transpose();
	}
	const Block diagonal(factorBlock(place, place), Eigen::OuterStride<>(width(place)));
	for (int i = kSide - 1; i >= 0; --i)
	{
		own(i) *= diagonal(i, i);
		for (int j = 0; j < i; ++j) own(j) -= diagonal(i, j) * own(i);
	}
	m_products += uint64_t(cliqueEnd(place) - cliqueBegin(place)) + 1;
}

void btEnvelopeFactor::solve(double* x)
{
	substituteForward(x);
	for (int place = m_places - 1; place >= 0; --place) substituteBack(x, place);
}
