// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/Partition/SplitPlane.h"

#include "BulletISTCollision/Core/Base/SymmetricEigen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
constexpr size_t kEnoughSamples = 240;
constexpr size_t kWorstSamples = 12;
// Each side has at least 3 samples and 1/80 of them. Few samples may be divided anyhow: they are left where faces meet.
constexpr size_t kFewestOfSide = 3, kLeastShareOfSide = 80, kFewSamples = 24;
constexpr size_t kFewestOfCluster = 4, kFewestWithin = 12;
constexpr int kClusterRounds = 6;
constexpr int kPairs = 4, kManyPairs = 24, kPairsAcross = 8, kDrawsPerPair = 4;
constexpr size_t kThorough = 1000;  // with so many samples, the search tries many pairs
constexpr int kRefinements = 2;
constexpr double kLeastTurn = 0.05;    // least difference of two gradients that make a crease
constexpr double kLeastSpread = 1e-6;  // least variance of normals that have two clusters

using Samples = std::vector<DepthSample>;
struct Moments
{
	Vec3 mean;
	double covariance[3][3] = {};
};

template <class Vector> Moments momentsOf(const Samples& samples, const Vector& vector)
{
	Moments m;
	for (const DepthSample& s : samples) m.mean += vector(s);
	m.mean *= 1 / double(samples.size());
	for (const DepthSample& s : samples)
	{
		const Vec3 y = vector(s) - m.mean;
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) m.covariance[i][j] += y[i] * y[j] / double(samples.size());
	}
	return m;
}

/// The principal axes, the longest first, and their variances. The sign of an axis is that of its largest component.
struct Axes
{
	std::array<Vec3, 3> direction;
	std::array<double, 3> variance{};
};

Axes axesOf(const Moments& m)
{
	Axes axes{{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}, {}};
	SymmetricEigen<3> eigen;
	if (!eigen.decompose(m.covariance)) return axes;
	std::array<int, 3> order{0, 1, 2};
	std::sort(order.begin(), order.end(), [&](int a, int b) { return eigen.values[a] > eigen.values[b]; });
	for (size_t k = 0; k < 3; ++k)
	{
		const double(&v)[3] = eigen.vectors[order[k]];
		axes.direction[k] = {v[0], v[1], v[2]};
		axes.variance[k] = std::max(0.0, eigen.values[order[k]]);
	}
	return axes;
}

/// Two groups of samples with similar normals.
struct Clusters
{
	Samples first, second;
	bool areUsable() const { return first.size() >= kFewestOfCluster && second.size() >= kFewestOfCluster; }
};

Vec3 meanPosition(const Samples& samples)
{
	Vec3 sum;
	for (const DepthSample& s : samples) sum += s.position;
	return sum / double(samples.size());
}

Vec3 meanNormal(const Samples& samples)
{
	Vec3 sum;
	for (const DepthSample& s : samples) sum += s.normal;
	return sum / double(samples.size());
}

/// Two-means clustering of the normals; empty if all normals are equal.
Clusters clustersOf(const Samples& samples)
{
	const Moments normals = momentsOf(samples, [](const DepthSample& s) { return s.normal; });
	const Axes axes = axesOf(normals);
	Clusters clusters;
	if (axes.variance[0] < kLeastSpread) return clusters;
	const Vec3 away = axes.direction[0] * std::sqrt(axes.variance[0]);
	Vec3 first = normals.mean + away, second = normals.mean - away;
	for (int round = 0; round < kClusterRounds; ++round)
	{
		clusters.first.clear(), clusters.second.clear();
		for (const DepthSample& s : samples)
		{
			const bool nearFirst = squaredNorm(s.normal - first) < squaredNorm(s.normal - second);
			(nearFirst ? clusters.first : clusters.second).push_back(s);
		}
		if (!clusters.areUsable()) break;
		first = meanNormal(clusters.first), second = meanNormal(clusters.second);
	}
	return clusters;
}

bool isWithin(const DepthSample& s) { return !s.isOutside(); }

class PlaneSearch
{
public:
	PlaneSearch(std::span<const DepthSample> samples, const QuadricFit& fit, double spacing, double rounding, CounterRandom random)
		: m_spacing(spacing),
		  m_rounding(rounding),
		  m_random(random)
	{
		const size_t stride = std::max<size_t>(1, samples.size() / kEnoughSamples);
		if (stride > 1) m_samples = worstOf(samples, fit);
		m_isThorough = samples.size() >= kThorough;
		m_worst = size_t(std::count_if(m_samples.begin(), m_samples.end(), isWithin));
		for (size_t i = 0; i < samples.size(); i += stride) m_samples.push_back(samples[i]);
		std::copy_if(m_samples.begin(), m_samples.end(), std::back_inserter(m_within), isWithin);
		if (m_within.size() < kFewestWithin) m_within = m_samples;
	}

	std::optional<SplitPlane> run()
	{
		const Moments places = momentsOf(m_within, [](const DepthSample& s) { return s.position; });
		for (const Vec3& axis : axesOf(places).direction) tryPlane(axis, dot(axis, places.mean));
		const Vec3 normal = meanNormal(m_within);
		tryPlane(normal, dot(normal, places.mean));
		tryClusters(places);
		tryPairs();
		if (m_isThorough && m_squares < kNone) tryPairsAcross();
		refine();
		if (m_squares == kNone) return {};
		return m_best;
	}

private:
	/// Without these samples, a small piece of another face would not be seen.
	Samples worstOf(std::span<const DepthSample> samples, const QuadricFit& fit) const
	{
		std::vector<std::pair<double, size_t>> errors;
		errors.reserve(samples.size());
		for (size_t i = 0; i < samples.size(); ++i)
		{
			const double e = errorAt(fit, samples[i], m_spacing);
			errors.push_back({-samples[i].weight * e * e, i});
		}
		const size_t count = std::min(kWorstSamples, errors.size());
		std::partial_sort(errors.begin(), errors.begin() + std::ptrdiff_t(count), errors.end());
		Samples worst;
		for (size_t k = 0; k < count; ++k) worst.push_back(samples[errors[k].second]);
		return worst;
	}

	static constexpr double kNone = std::numeric_limits<double>::infinity();

	/// Divides the samples; false if one side has too few.
	bool divide(const SplitPlane& plane)
	{
		m_sides.first.clear(), m_sides.second.clear();
		for (const DepthSample& s : m_samples)
		{
			const double beyond = plane.beyond(s.position);
			if (std::fabs(beyond) >= m_rounding) (beyond > 0 ? m_sides.second : m_sides.first).push_back(s);
		}
		const size_t count = m_samples.size(), least = count < kFewSamples ? 1 : std::max(kFewestOfSide, count / kLeastShareOfSide);
		return m_sides.first.size() >= least && m_sides.second.size() >= least;
	}

	/// Keeps the plane if it is better than those before. `normal` may have any length.
	bool tryPlane(const Vec3& normal, double offset)
	{
		const double length = norm(normal);
		if (!(length > 1e-9)) return false;
		const SplitPlane plane{normal / length, offset / length};
		if (!divide(plane)) return false;
		const double first = fitQuadric(m_sides.first, m_spacing).squares;
		if (!(first < m_squares)) return false;
		const double squares = first + fitQuadric(m_sides.second, m_spacing).squares;
		if (!(squares < m_squares)) return false;
		m_best = plane;
		m_squares = squares;
		return true;
	}

	/// The plane where the depths of two quadrics are equal, to first order about `middle`.
	bool tryCrease(const Quadric& a, const Quadric& b, const Vec3& middle)
	{
		const Vec3 turn = b.gradientAt(middle) - a.gradientAt(middle);
		if (norm(turn) < kLeastTurn) return false;
		return tryPlane(turn, dot(turn, middle) + a.depthAt(middle) - b.depthAt(middle));
	}

	void tryClusters(const Moments& places)
	{
		const Clusters clusters = clustersOf(m_within);
		if (!clusters.areUsable()) return;
		const Vec3 first = meanPosition(clusters.first), second = meanPosition(clusters.second), middle = (first + second) * 0.5;
		const Quadric a = fitQuadric(clusters.first, m_spacing).quadric, b = fitQuadric(clusters.second, m_spacing).quadric;
		tryCrease(a, b, middle);
		const Vec3 axis = discriminant(places, first - second);
		tryPlane(axis, dot(axis, middle));
	}

	/// The inverse of the covariance times the vector.
	static Vec3 discriminant(const Moments& places, const Vec3& between)
	{
		const Axes axes = axesOf(places);
		const double least = 1e-9 * axes.variance[0];
		Vec3 result;
		if (!(least > 0)) return result;
		for (size_t k = 0; k < 3; ++k)
			result += axes.direction[k] * (dot(axes.direction[k], between) * axes.variance[0] / std::max(least, axes.variance[k]));
		return result;
	}

	/// The bisector of the tangent planes of two samples: between flat faces the exact crease. False if the depth has none there.
	bool tryPair(const DepthSample& a, const DepthSample& b)
	{
		const Vec3 turn = a.normal - b.normal;
		if (norm(turn) < kLeastTurn) return false;
		// In a convex crease the depth is the smaller one of the two, in a concave one the larger one, at both samples.
		const double atA = b.depth - dot(b.normal, a.position - b.position) - a.depth;
		const double atB = a.depth - dot(a.normal, b.position - a.position) - b.depth;
		if (!(atA * atB > 0)) return false;
		tryPlane(turn, a.depth + dot(a.normal, a.position) - b.depth - dot(b.normal, b.position));
		return true;
	}

	void tryPairs()
	{
		const int most = m_isThorough ? kManyPairs : kPairs;
		for (int draw = 0, pairs = 0; draw < kDrawsPerPair * most && pairs < most; ++draw)
		{
			const DepthSample& a = randomOf(m_within, draw % 2 == 0 ? m_worst : 0);
			if (tryPair(a, randomOf(m_within))) ++pairs;
		}
	}

	/// Pairs with a sample on each side of the best plane. So a plane close to an exact crease is replaced by it.
	void tryPairsAcross()
	{
		divide(m_best);
		Clusters within;
		std::copy_if(m_sides.first.begin(), m_sides.first.end(), std::back_inserter(within.first), isWithin);
		std::copy_if(m_sides.second.begin(), m_sides.second.end(), std::back_inserter(within.second), isWithin);
		if (within.first.empty() || within.second.empty()) return;
		for (int draw = 0, pairs = 0; draw < kDrawsPerPair * kPairsAcross && pairs < kPairsAcross; ++draw)
			if (tryPair(randomOf(within.first), randomOf(within.second))) ++pairs;
	}

	/// One of the first `most` samples, of all if zero.
	const DepthSample& randomOf(const Samples& samples, size_t most = 0)
	{
		const size_t count = most > 0 ? std::min(most, samples.size()) : samples.size();
		return samples[std::min(count - 1, size_t(m_random.next() * double(count)))];
	}

	/// Replaces the best plane by the crease between the quadrics on its sides while this is better.
	void refine()
	{
		for (int k = 0; k < kRefinements && m_squares < kNone && m_squares > 0; ++k)
		{
			divide(m_best);
			const QuadricFit a = fitQuadric(m_sides.first, m_spacing), b = fitQuadric(m_sides.second, m_spacing);
			const Vec3 between = (a.quadric.center + b.quadric.center) * 0.5;
			const Vec3 middle = between - m_best.normal * m_best.beyond(between);
			if (!tryCrease(a.quadric, b.quadric, middle)) return;
		}
	}

	double m_spacing, m_rounding;
	CounterRandom m_random;
	Samples m_samples, m_within;  // the worst come first
	size_t m_worst = 0;           // their number
	bool m_isThorough = false;
	Clusters m_sides;  // of the plane tried last
	SplitPlane m_best;
	double m_squares = kNone;
};
}  // namespace

std::optional<SplitPlane> findSplitPlane(
	std::span<const DepthSample> samples, const QuadricFit& fit, double spacing, double rounding, CounterRandom random)
{
	return PlaneSearch(samples, fit, spacing, rounding, random).run();
}
}  // namespace ist
