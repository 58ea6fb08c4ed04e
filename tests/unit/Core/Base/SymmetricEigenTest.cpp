// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

using namespace ist;

namespace
{
template <int N> using Matrix = double[N][N];

/// Q diag(spectrum) Q^T with Q a product of random rotations of two axes.
template <int N> void turned(const std::array<double, N>& spectrum, std::mt19937& random, Matrix<N>& a)
{
	std::uniform_real_distribution<double> angle(-3, 3);
	for (int i = 0; i < N; ++i)
		for (int j = 0; j < N; ++j) a[i][j] = i == j ? spectrum[static_cast<std::size_t>(i)] : 0;
	for (int p = 0; p < N; ++p)
		for (int q = p + 1; q < N; ++q)
		{
			const double t = angle(random), c = std::cos(t), s = std::sin(t);
			for (int k = 0; k < N; ++k)
			{
				const double x = a[p][k], y = a[q][k];
				a[p][k] = c * x - s * y;
				a[q][k] = s * x + c * y;
			}
			for (int k = 0; k < N; ++k)
			{
				const double x = a[k][p], y = a[k][q];
				a[k][p] = c * x - s * y;
				a[k][q] = s * x + c * y;
			}
		}
	for (int i = 0; i < N; ++i)
		for (int j = 0; j < i; ++j) a[i][j] = a[j][i];
}

template <int N> double sizeOf(const Matrix<N>& a)
{
	double largest = 0;
	for (const auto& row : a)
		for (const double x : row) largest = std::max(largest, std::fabs(x));
	return largest;
}

/// Checks the decomposition completely: the vectors are orthonormal and they give the matrix back.
template <int N> void expectDecomposed(const Matrix<N>& a)
{
	SymmetricEigen<N> eigen;
	ASSERT_TRUE(eigen.decompose(a));
	const double rounding = 1e-14 * N;
	for (int k = 0; k < N; ++k)
		for (int l = 0; l < N; ++l)
		{
			double product = 0;
			for (int i = 0; i < N; ++i) product += eigen.vectors[k][i] * eigen.vectors[l][i];
			EXPECT_NEAR(product, k == l ? 1 : 0, rounding);
		}
	for (int i = 0; i < N; ++i)
		for (int j = 0; j < N; ++j)
		{
			double sum = 0;
			for (int k = 0; k < N; ++k) sum += eigen.values[k] * eigen.vectors[k][i] * eigen.vectors[k][j];
			EXPECT_LE(std::fabs(sum - a[i][j]), rounding * sizeOf<N>(a)) << i << j;
		}
}
}  // namespace

TEST(SymmetricEigen, FindsTheSpectrumThatAMatrixWasMadeWith)
{
	std::mt19937 random(1);
	const std::array<double, 6> spectra[] = {{1, 2, 3, 4, 5, 6}, {-1, -1, -1, 2, 2, 2}, {7, 0, 0, 0, 0, 0}, {0, 0, 0, 0, 0, 0},
		{1, 1 + 1e-9, 1 - 1e-9, -1e-6, 1e6, -1e6}, {-3, -2, -1, -1e-12, 1e-12, 1e3}};
	for (const auto& spectrum : spectra)
		for (int turn = 0; turn < 20; ++turn)
		{
			Matrix<6> a;
			turned<6>(spectrum, random, a);
			expectDecomposed<6>(a);
			SymmetricEigen<6> eigen;
			ASSERT_TRUE(eigen.decompose(a));
			std::array<double, 6> wanted = spectrum;
			std::sort(wanted.begin(), wanted.end());
			std::sort(eigen.values, eigen.values + 6);
			for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(eigen.values[k], wanted[k], 1e-13 * sizeOf<6>(a)) << k;
		}
}

TEST(SymmetricEigen, TakesMatricesOfEverySizeAndSparsity)
{
	std::mt19937 random(2);
	for (const double size : {1e-200, 1e-30, 1.0, 1e30, 1e200})
	{
		Matrix<3> a;
		turned<3>({-2 * size, 0.5 * size, size}, random, a);
		expectDecomposed<3>(a);
	}
	std::uniform_int_distribution<int> entry(-1, 1);
	for (int i = 0; i < 500; ++i)  // mostly zeros: connected and separate parts
	{
		Matrix<6> a;
		for (int r = 0; r < 6; ++r)
			for (int c = r; c < 6; ++c) a[r][c] = a[c][r] = entry(random) * entry(random);
		expectDecomposed<6>(a);
	}
	Matrix<6> chain = {};
	for (int i = 0; i < 5; ++i) chain[i][i + 1] = chain[i + 1][i] = 1;
	expectDecomposed<6>(chain);
	SymmetricEigen<6> eigen;  // its eigenvalues are 2 cos(k pi / 7)
	ASSERT_TRUE(eigen.decompose(chain));
	EXPECT_NEAR(*std::max_element(eigen.values, eigen.values + 6), 2 * std::cos(std::acos(-1.0) / 7), 1e-14);
}

// A contact that turns flat has such matrices: what is oblique fades, and at last it underflows.
TEST(SymmetricEigen, TakesEntriesThatFadeDownToTheSmallestNumbers)
{
	std::mt19937 random(3);
	std::uniform_real_distribution<double> anySize(-323, 0), sign(-1, 1);
	std::uniform_real_distribution<double> belowRoots(-170, -155);  // their squares underflow, in part or wholly
	for (const bool hasOne : {false, true})
		for (int i = 0; i < 20'000; ++i)
		{
			auto& exponent = hasOne ? belowRoots : anySize;
			Matrix<6> a;
			for (int r = 0; r < 6; ++r)
				for (int c = r; c < 6; ++c) a[r][c] = a[c][r] = std::copysign(std::pow(10, exponent(random)), sign(random));
			if (hasOne) a[i % 6][i % 6] = 1;
			expectDecomposed<6>(a);
			if (HasFailure()) return;
		}
}

TEST(SymmetricEigen, RefusesWhatIsNotFinite)
{
	for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
	{
		Matrix<3> a = {{1, 0, 0}, {0, 1, bad}, {0, bad, 1}};
		EXPECT_FALSE(SymmetricEigen<3>().decompose(a));
	}
}
