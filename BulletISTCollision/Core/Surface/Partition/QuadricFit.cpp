// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/Partition/QuadricFit.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace ist
{
namespace
{
constexpr double kGradientShare = 0.05;  // weight of the equations of the gradient, which have no unit after scaling
// Penalties on the second derivatives, relative to the weight of all samples. The larger ones apply where the quadric would bend more than
// kMostBend over its radius or over the spacing, as few samples let it. The largest leaves no second derivatives.
constexpr double kFlat = 1e6;
constexpr double kPenalties[] = {1e-7, 1e-3, kFlat};
constexpr double kMostBend = 2;
// Where a quadric is this exact, in spacings, the samples may lie on a plane. Then a linear fit is as good and safer between them.
constexpr double kNearlyExact = 1e-5, kExact = 1e-7;
constexpr double kRidge = 1e-12;
// Least unit of the scaled coordinates, in spacings. With a smaller one, samples outside would be millions of units away.
constexpr double kLeastScale = 0.1;
constexpr int kRounds = 2;  // of adding the inequalities that do not hold
// Outside, the quadric must lie between kUpper * depth and kLower * depth - kLowerShare * spacing. A query drops what is far outside by it.
constexpr double kUpper = 0.02, kLower = 2, kLowerShare = 0.2;

constexpr int kTerms = 10;
/// Index of the coefficient of the second derivative by the axes k and l.
constexpr int kSecond[3][3] = {{4, 7, 8}, {7, 5, 9}, {8, 9, 6}};

/// Two numbers in one register. Sums of numbers that were stored one by one and loaded in pairs wait for the stores.
typedef double Pair __attribute__((vector_size(16)));
constexpr int kPairs = kTerms / 2;

/// Values of the terms at a scaled point.
struct Terms
{
	Pair pairs[kPairs];
	explicit Terms(const Vec3& y)
		: pairs{{1, y.x}, {y.y, y.z}, {0.5 * y.x * y.x, 0.5 * y.y * y.y}, {0.5 * y.z * y.z, y.x * y.y}, {y.x * y.z, y.y * y.z}}
	{}
	double value(int i) const { return pairs[i / 2][i % 2]; }
};

/// sums[2 k, 2 k + 1] += factor * pairs[k], for k < kCount
template <int kCount> void addPairs(double* sums, double factor, const Pair* pairs)
{
	for (int k = 0; k < kCount; ++k)
	{
		Pair sum;
		std::memcpy(&sum, sums + 2 * k, sizeof sum);
		sum += factor * pairs[k];
		std::memcpy(sums + 2 * k, &sum, sizeof sum);
	}
}

/// Weighted sums of the components of the normals times the linear terms.
struct NormalSums
{
	double of[3][4] = {};
	void add(const Terms& p, double weight, const Vec3& normal)
	{
		addPairs<2>(of[0], weight * normal.x, p.pairs);
		addPairs<2>(of[1], weight * normal.y, p.pairs);
		addPairs<2>(of[2], weight * normal.z, p.pairs);
	}
};

/// Normal equations of the least squares: the lower triangle of the matrix, and the right side. What is right of the diagonal is undefined.
struct NormalEquations
{
	double a[kTerms][kTerms] = {}, r[kTerms] = {};

	void add(const Terms& p, double weight, double target) { addRows(p, weight, target, std::make_integer_sequence<int, kTerms>()); }

	/// Adds the equations gradient = -n of all samples so far.
	void addGradients(const NormalSums& normals)
	{
		double linear[4][4];
		for (int i = 0; i < 4; ++i)
			for (int j = 0; j <= i; ++j) linear[i][j] = linear[j][i] = kGradientShare * a[i][j];
		for (int k = 0; k < 3; ++k)
		{
			const int terms[4] = {1 + k, kSecond[k][0], kSecond[k][1], kSecond[k][2]};
			for (int i = 0; i < 4; ++i)
			{
				r[terms[i]] -= kGradientShare * normals.of[k][i];
				for (int j = 0; j < 4; ++j)
					if (terms[j] <= terms[i]) a[terms[i]][terms[j]] += linear[i][j];
			}
		}
	}

	/// Cholesky's method with a penalty on the second derivatives.
	void solve(double penalty, double (&z)[kTerms]) const
	{
		double l[kTerms][kTerms], inverse[kTerms];
		for (int i = 0; i < kTerms; ++i)
		{
			for (int j = 0; j <= i; ++j)
			{
				double sum = a[i][j];
				if (i == j) sum += a[0][0] * (i < 4 ? kRidge : penalty);
				for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
				if (i > j) l[i][j] = sum * inverse[j];
				else inverse[i] = sum > 0 ? 1 / std::sqrt(sum) : 0;
			}
			double sum = r[i];
			for (int k = 0; k < i; ++k) sum -= l[i][k] * z[k];
			z[i] = sum * inverse[i];
		}
		for (int i = kTerms - 1; i >= 0; --i)
		{
			double sum = z[i];
			for (int k = i + 1; k < kTerms; ++k) sum -= l[k][i] * z[k];
			z[i] = sum * inverse[i];
		}
	}

private:
	template <int... kRows> void addRows(const Terms& p, double weight, double target, std::integer_sequence<int, kRows...>)
	{
		(addPairs<kRows / 2 + 1>(a[kRows], weight * p.value(kRows), p.pairs), ...);
		const Pair targets = {target, target};
		Pair products[kPairs];
		for (int k = 0; k < kPairs; ++k) products[k] = weight * p.pairs[k] * targets;
		addPairs<kPairs>(r, 1, products);
	}
};

/// Origin and unit of the scaled coordinates.
struct Frame
{
	Vec3 center;
	double radius = 0, scale = 1;
	size_t within = 0;
	bool takes(const DepthSample& s) const { return within == 0 || !s.isOutside(); }
	Vec3 scaled(const Vec3& x) const { return (x - center) * (1 / scale); }
};

Frame frameOf(std::span<const DepthSample> samples, double spacing)
{
	Frame f;
	for (const DepthSample& s : samples) f.within += s.isOutside() ? 0 : 1;
	const double share = 1 / double(f.within > 0 ? f.within : samples.size());
	for (const DepthSample& s : samples)
		if (f.takes(s)) f.center += s.position * share;
	f.center = {float(f.center.x), float(f.center.y), float(f.center.z)};
	double square = 0;
	for (const DepthSample& s : samples)
		if (f.takes(s)) square += squaredNorm(s.position - f.center) * share;
	f.radius = std::sqrt(square);
	f.scale = std::max(f.radius, kLeastScale * spacing);
	return f;
}

NormalEquations equationsOf(std::span<const DepthSample> samples, const Frame& f)
{
	NormalEquations e;
	NormalSums normals;
	for (const DepthSample& s : samples)
	{
		if (!f.takes(s)) continue;
		const Terms p(f.scaled(s.position));
		e.add(p, s.weight, s.depth / f.scale);
		normals.add(p, s.weight, s.normal);
	}
	e.addGradients(normals);
	return e;
}

double bendOf(const double (&z)[kTerms])
{
	double square = 0;
	for (int k = 0; k < 3; ++k)
		for (int l = 0; l < 3; ++l) square += z[kSecond[k][l]] * z[kSecond[k][l]];
	return std::sqrt(square);
}

Quadric quadricOf(const double (&z)[kTerms], const Frame& f)
{
	Quadric q;
	q.center = f.center;
	q.depth = z[0] * f.scale;
	q.gradient = {z[1], z[2], z[3]};
	for (int k = 0; k < 6; ++k) q.hessian[k] = z[4 + k] / f.scale;
	return q;
}

Quadric solutionOf(const NormalEquations& e, const Frame& f, double spacing)
{
	const double most = kMostBend * std::min(1.0, f.scale / spacing);
	double z[kTerms];
	for (const double penalty : kPenalties)
	{
		e.solve(penalty, z);
		if (bendOf(z) <= most) break;
	}
	return quadricOf(z, f);
}

Quadric linearSolutionOf(const NormalEquations& e, const Frame& f)
{
	double z[kTerms];
	e.solve(kFlat, z);
	return quadricOf(z, f);
}

/// The nearest value to `value` that a sample outside permits.
double permitted(const DepthSample& s, double value, double spacing)
{
	return std::clamp(value, kLower * s.depth - kLowerShare * spacing, kUpper * s.depth);
}

/// Fits again with the inequalities that do not hold, as equations for the nearest permitted value.
void holdOutside(std::span<const DepthSample> samples, const Frame& f, const NormalEquations& within, double spacing, Quadric& q)
{
	for (int round = 0; round < kRounds; ++round)
	{
		NormalEquations all = within;
		bool holds = true;
		for (const DepthSample& s : samples)
		{
			if (!s.isOutside()) continue;
			const double value = q.depthAt(s.position), target = permitted(s, value, spacing);
			if (value == target) continue;
			holds = false;
			all.add(Terms(f.scaled(s.position)), s.weight, target / f.scale);
		}
		if (holds) return;
		q = solutionOf(all, f, spacing);
	}
}
}  // namespace

double errorAt(const QuadricFit& fit, const DepthSample& sample, double spacing)
{
	const double value = fit.quadric.depthAt(sample.position);
	const bool isEquation = fit.within == 0 || !sample.isOutside();
	return value - (isEquation ? sample.depth : permitted(sample, value, spacing));
}

namespace
{
/// Sets the errors of the fit.
void measure(std::span<const DepthSample> samples, double spacing, QuadricFit& fit)
{
	fit.squares = fit.largest = fit.error = 0;
	for (const DepthSample& s : samples)
	{
		const double off = errorAt(fit, s, spacing);
		fit.squares += s.weight * off * off;
		fit.largest = std::max(fit.largest, std::fabs(off));
		if (!s.isOutside()) fit.error += off * off;
	}
	fit.error = std::sqrt(fit.error / double(std::max<size_t>(1, fit.within)));
}
}  // namespace

QuadricFit fitQuadric(std::span<const DepthSample> samples, double spacing)
{
	QuadricFit fit;
	if (samples.empty()) return fit;
	const Frame f = frameOf(samples, spacing);
	const NormalEquations equations = equationsOf(samples, f);
	fit.quadric = solutionOf(equations, f, spacing);
	fit.within = f.within;
	fit.radius = f.radius;
	if (f.within > 0 && f.within < samples.size()) holdOutside(samples, f, equations, spacing, fit.quadric);
	measure(samples, spacing, fit);
	if (fit.largest > kNearlyExact * spacing) return fit;
	QuadricFit linear = fit;
	linear.quadric = linearSolutionOf(equations, f);
	measure(samples, spacing, linear);
	return linear.largest <= kExact * spacing ? linear : fit;
}
}  // namespace ist
