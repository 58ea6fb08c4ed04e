// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace ist
{
/// Eigenvalues and eigenvectors of a small symmetric matrix A = sum_k values[k] v_k v_k^T, where v_k = vectors[k] are orthonormal. They
/// have no particular order. Method: Householder reflections to tridiagonal form, then implicit QL with Wilkinson's shift. The errors are
/// a few roundings of |A|. O(N^3), no allocation.
template <int N> class SymmetricEigen
{
public:
	double values[N];
	double vectors[N][N];

	/// Decomposes the full matrix, which must be symmetric. False if it is not finite; the members are then undefined.
	bool decompose(const double (&matrix)[N][N]) noexcept;

private:
	/// Entries that are smaller than this share of the largest one count as zero: they are far below the rounding, and their squares would
	/// underflow.
	static constexpr double kNegligible = 1e-40;

	static void reflect(double (&a)[N][N], int k, double (&axis)[N]) noexcept;
	void accumulate(const double (&axes)[N][N]) noexcept;
	bool solveThreeDiagonals(double (&beside)[N]) noexcept;
	void sweep(int first, int last, double (&beside)[N]) noexcept;
	void turn(int i, double c, double s) noexcept;
};

/// Multiplying by I - axis axis^T from both sides zeroes column and row `k` outside the three diagonals. Rows up to `k` are not updated.
template <int N> void SymmetricEigen<N>::reflect(double (&a)[N][N], int k, double (&axis)[N]) noexcept
{
	double v[N] = {}, product[N] = {}, beyond = 0, along = 0;
	for (int i = k + 2; i < N; ++i) beyond += a[k][i] * a[k][i];
	if (beyond > kNegligible * kNegligible)
	{
		const double first = a[k][k + 1], length = std::sqrt(first * first + beyond);
		const double scale = 1 / std::sqrt(length * (length + std::fabs(first)));
		v[k + 1] = (first + std::copysign(length, first)) * scale;
		for (int i = k + 2; i < N; ++i) v[i] = a[k][i] * scale;
		a[k][k + 1] = std::copysign(length, -first);
		for (int i = k + 1; i < N; ++i)
			for (int j = 0; j < N; ++j) product[j] += v[i] * a[i][j];
		for (int i = 0; i < N; ++i) along += product[i] * v[i];
		for (int i = 0; i < N; ++i) product[i] -= 0.5 * along * v[i];
		for (int i = k + 1; i < N; ++i)
		{
			const double x = v[i], y = product[i];
			for (int j = 0; j < N; ++j) a[i][j] -= x * product[j] + y * v[j];
		}
	}
	for (int i = 0; i < N; ++i) axis[i] = v[i];
}

/// The product of the reflections, the last one first. Its columns are the rows of `vectors`.
template <int N> void SymmetricEigen<N>::accumulate(const double (&axes)[N][N]) noexcept
{
	double q[N][N] = {};
	for (int i = 0; i < N; ++i) q[i][i] = 1;
	for (int k = N - 3; k >= 0; --k)
	{
		double along[N] = {};
		for (int j = k + 1; j < N; ++j)
			for (int i = 0; i < N; ++i) along[i] += axes[k][j] * q[j][i];
		for (int j = k + 1; j < N; ++j)
		{
			const double x = axes[k][j];
			for (int i = 0; i < N; ++i) q[j][i] -= x * along[i];
		}
	}
	for (int i = 0; i < N; ++i)
		for (int j = 0; j < N; ++j) vectors[i][j] = q[j][i];
}

template <int N> void SymmetricEigen<N>::turn(int i, double c, double s) noexcept
{
	double x[N], y[N];
	for (int k = 0; k < N; ++k) x[k] = vectors[i][k], y[k] = vectors[i + 1][k];
	for (int k = 0; k < N; ++k) vectors[i][k] = c * x[k] - s * y[k];
	for (int k = 0; k < N; ++k) vectors[i + 1][k] = s * x[k] + c * y[k];
}

/// One implicit QL step on the rows `first` to `last`. It ends early if the matrix splits on the way.
template <int N> void SymmetricEigen<N>::sweep(int first, int last, double (&beside)[N]) noexcept
{
	const double half = (values[first + 1] - values[first]) / (2 * beside[first]);
	double g = values[last] - values[first] + beside[first] / (half + std::copysign(std::sqrt(half * half + 1), half));
	double s = 1, c = 1, p = 0;
	for (int i = last - 1; i >= first; --i)
	{
		const double f = s * beside[i], b = c * beside[i], square = f * f + g * g;
		if (!(square > kNegligible * kNegligible))
		{
			beside[i + 1] = 0;
			beside[i] = b;  // the last turn may have mirrored an axis
			values[i + 1] -= p;
			beside[last] = 0;
			return;
		}
		const double r = std::sqrt(square), inverse = 1 / r;
		beside[i + 1] = r;
		s = f * inverse;
		c = g * inverse;
		g = values[i + 1] - p;
		const double t = (values[i] - g) * s + 2 * c * b;
		p = s * t;
		values[i + 1] = g + p;
		g = c * t - b;
		turn(i, c, s);
	}
	values[first] -= p;
	beside[first] = g;
	beside[last] = 0;
}

template <int N> bool SymmetricEigen<N>::solveThreeDiagonals(double (&beside)[N]) noexcept
{
	constexpr int kMostSweeps = 30 * N;
	constexpr double kRounding = std::numeric_limits<double>::epsilon();
	const auto isApart = [&](int i) {
		return std::fabs(beside[i]) <= std::max(kRounding * (std::fabs(values[i]) + std::fabs(values[i + 1])), kNegligible);
	};
	int sweeps = 0;
	for (int first = 0; first < N - 1;)
	{
		if (isApart(first))
		{
			++first;
			continue;
		}
		int last = first + 1;
		while (last < N - 1 && !isApart(last)) ++last;
		if (++sweeps > kMostSweeps) return false;
		sweep(first, last, beside);
	}
	return true;
}

template <int N> bool SymmetricEigen<N>::decompose(const double (&matrix)[N][N]) noexcept
{
	double largest = 0, sum = 0;
	for (int i = 0; i < N; ++i)
		for (int j = i; j < N; ++j)
		{
			const double size = std::fabs(matrix[i][j]);
			sum += size;
			largest = size > largest ? size : largest;
		}
	if (!(sum <= std::numeric_limits<double>::max())) return false;
	// The scaling prevents that squares overflow or underflow.
	const double unit = largest > 0 ? 1 / largest : 0;
	double a[N][N], axes[N][N], beside[N];
	for (int i = 0; i < N; ++i)
		for (int j = 0; j < N; ++j) a[i][j] = unit * matrix[i][j];
	for (int k = 0; k < N - 2; ++k) reflect(a, k, axes[k]);
	for (int i = 0; i < N; ++i)
	{
		values[i] = a[i][i];
		beside[i] = i < N - 1 ? a[i][i + 1] : 0;
	}
	accumulate(axes);
	if (!solveThreeDiagonals(beside)) return false;
	for (double& value : values) value *= largest;
	return true;
}
}  // namespace ist
