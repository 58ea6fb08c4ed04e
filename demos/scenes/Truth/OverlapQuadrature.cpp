// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

using namespace ist;

namespace scenes
{
namespace
{
struct Interval
{
	double begin, end;
};

/// An infinite line with a right-handed frame: u x v = direction.
struct Line
{
	Vec3 origin, u, v, direction;
};

struct Crossing
{
	double t;
	int step;  // +1 enters, -1 leaves
};

struct Nearest
{
	Vec3 point;
	double distance = 0;
};

Vec3 nearestOnSegment(const Vec3& p, const Vec3& a, const Vec3& b)
{
	const Vec3 e = b - a;
	const double length2 = squaredNorm(e);
	const double t = length2 > 0 ? std::clamp(dot(p - a, e) / length2, 0.0, 1.0) : 0.0;
	return a + t * e;
}

/// Nearest point: the foot on the plane if it lies inside the triangle, otherwise the best point of the three edges.
Vec3 nearestOnTriangle(const Vec3& p, const std::array<Vec3, 3>& t)
{
	const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
	const double n2 = squaredNorm(n);
	if (n2 > 0)
	{
		bool inside = true;
		for (int i = 0; i < 3 && inside; ++i) inside = dot(cross(t[(i + 1) % 3] - t[i], p - t[i]), n) >= 0;
		if (inside) return p - (dot(p - t[0], n) / n2) * n;
	}
	Vec3 best = nearestOnSegment(p, t[0], t[1]);
	for (int i = 1; i < 3; ++i)
	{
		const Vec3 q = nearestOnSegment(p, t[i], t[(i + 1) % 3]);
		if (squaredNorm(q - p) < squaredNorm(best - p)) best = q;
	}
	return best;
}

/// A binary tree of boxes over triangles, split at the median of the longest axis.
class TriangleTree
{
public:
	explicit TriangleTree(const Mesh& mesh)
	{
		for (const auto& corner : mesh.triangles)
			m_triangles.push_back({mesh.vertices[corner[0]], mesh.vertices[corner[1]], mesh.vertices[corner[2]]});
		build(0, m_triangles.size());
		m_slack = 1e-12 * (norm(m_nodes[0].upper - m_nodes[0].lower) + norm(m_nodes[0].lower));
	}

	const std::vector<std::array<Vec3, 3>>& triangles() const { return m_triangles; }

	/// Replaces `inside` by the intervals of the line with a positive winding number. Returns false when the winding number does not
	/// return to zero.
	bool trace(const Line& line, std::vector<Crossing>& crossings, std::vector<Interval>& inside) const;
	Nearest nearest(const Vec3& p) const;

private:
	struct Node
	{
		Vec3 lower, upper;
		size_t begin = 0, end = 0;  // triangles of a leaf; empty in an inner node
		size_t right = 0;           // index of the right child; the left child follows its parent
	};

	size_t build(size_t begin, size_t end);
	bool meets(const Node& node, const Line& line, const Vec3& inverse) const;
	static double squaredDistance(const Node& node, const Vec3& p);

	std::vector<std::array<Vec3, 3>> m_triangles;
	std::vector<Node> m_nodes;
	double m_slack = 0;
};

size_t TriangleTree::build(size_t begin, size_t end)
{
	Vec3 lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
	for (size_t i = begin; i < end; ++i)
		for (const Vec3& p : m_triangles[i])
		{
			lower = componentMin(lower, p);
			upper = componentMax(upper, p);
		}
	const size_t index = m_nodes.size();
	m_nodes.push_back({lower, upper, 0, 0, 0});
	if (end - begin <= 4)
	{
		m_nodes[index].begin = begin;
		m_nodes[index].end = end;
		return index;
	}
	const Vec3 side = upper - lower;
	const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
	const size_t middle = (begin + end) / 2;
	std::nth_element(m_triangles.begin() + begin, m_triangles.begin() + middle, m_triangles.begin() + end,
		[axis](const auto& a, const auto& b) { return a[0][axis] + a[1][axis] + a[2][axis] < b[0][axis] + b[1][axis] + b[2][axis]; });
	build(begin, middle);
	const size_t right = build(middle, end);
	m_nodes[index].right = right;
	return index;
}

bool TriangleTree::meets(const Node& node, const Line& line, const Vec3& inverse) const
{
	double first = -1e300, last = 1e300;
	for (int axis = 0; axis < 3; ++axis)
	{
		const double a = (node.lower[axis] - m_slack - line.origin[axis]) * inverse[axis];
		const double b = (node.upper[axis] + m_slack - line.origin[axis]) * inverse[axis];
		first = std::max(first, std::min(a, b));
		last = std::min(last, std::max(a, b));
	}
	return first <= last;
}

double TriangleTree::squaredDistance(const Node& node, const Vec3& p)
{
	return squaredNorm(p - componentMin(componentMax(p, node.lower), node.upper));
}

/// The edge functions of a shared edge are exact negatives of each other, so a line cannot slip between two triangles.
void addCrossing(const std::array<Vec3, 3>& triangle, const Line& line, std::vector<Crossing>& crossings)
{
	double x[3], y[3], e[3];
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 d = triangle[i] - line.origin;
		x[i] = dot(d, line.u);
		y[i] = dot(d, line.v);
	}
	for (int i = 0; i < 3; ++i)
	{
		const int j = (i + 1) % 3, k = (i + 2) % 3;
		e[i] = x[j] * y[k] - y[j] * x[k];
	}
	const bool leaves = e[0] >= 0 && e[1] >= 0 && e[2] >= 0;
	const bool enters = e[0] <= 0 && e[1] <= 0 && e[2] <= 0;
	const double sum = e[0] + e[1] + e[2];
	if (leaves == enters || sum == 0) return;
	double t = 0;
	for (int i = 0; i < 3; ++i) t += e[i] / sum * dot(triangle[i] - line.origin, line.direction);
	crossings.push_back({t, enters ? 1 : -1});
}

bool TriangleTree::trace(const Line& line, std::vector<Crossing>& crossings, std::vector<Interval>& inside) const
{
	crossings.clear();
	inside.clear();
	const Vec3 inverse{1 / line.direction.x, 1 / line.direction.y, 1 / line.direction.z};
	size_t stack[64], top = 0;
	stack[top++] = 0;
	while (top > 0)
	{
		const size_t index = stack[--top];
		const Node& node = m_nodes[index];
		if (!meets(node, line, inverse)) continue;
		for (size_t i = node.begin; i < node.end; ++i) addCrossing(m_triangles[i], line, crossings);
		if (node.begin == node.end)
		{
			stack[top++] = index + 1;
			stack[top++] = node.right;
		}
	}
	std::sort(crossings.begin(), crossings.end(),
		[](const Crossing& a, const Crossing& b) { return a.t < b.t || (a.t == b.t && a.step > b.step); });
	int winding = 0;
	for (const Crossing& crossing : crossings)
	{
		const int before = winding;
		winding += crossing.step;
		if (before <= 0 && winding > 0) inside.push_back({crossing.t, crossing.t});
		if (before > 0 && winding <= 0) inside.back().end = crossing.t;
	}
	if (winding == 0) return true;
	inside.clear();
	return false;
}

Nearest TriangleTree::nearest(const Vec3& p) const
{
	Nearest best;
	double best2 = 1e300;
	std::pair<double, size_t> stack[64];
	size_t top = 0;
	stack[top++] = {squaredDistance(m_nodes[0], p), 0};
	while (top > 0)
	{
		const auto [bound, index] = stack[--top];
		if (bound >= best2) continue;
		const Node& node = m_nodes[index];
		for (size_t i = node.begin; i < node.end; ++i)
		{
			const Vec3 q = nearestOnTriangle(p, m_triangles[i]);
			const double d2 = squaredNorm(q - p);
			if (d2 < best2)
			{
				best2 = d2;
				best.point = q;
			}
		}
		if (node.begin != node.end) continue;
		std::pair<double, size_t> near{squaredDistance(m_nodes[index + 1], p), index + 1};
		std::pair<double, size_t> far{squaredDistance(m_nodes[node.right], p), node.right};
		if (far.first < near.first) std::swap(near, far);
		stack[top++] = far;
		stack[top++] = near;
	}
	best.distance = std::sqrt(best2);
	return best;
}

OverlapQuadrature::Extent measure(const Mesh& mesh)
{
	OverlapQuadrature::Extent extent;
	Vec3 middle;
	for (const Vec3& p : mesh.vertices) middle += p / static_cast<double>(mesh.vertices.size());
	Vec3 moment;
	for (const auto& corner : mesh.triangles)
	{
		const Vec3 a = mesh.vertices[corner[0]] - middle, b = mesh.vertices[corner[1]] - middle, c = mesh.vertices[corner[2]] - middle;
		const double v = dot(a, cross(b, c)) / 6;
		extent.volume += v;
		moment += v / 4 * (a + b + c);
	}
	extent.center = middle + moment / extent.volume;
	for (const Vec3& p : mesh.vertices) extent.radius = std::max(extent.radius, distance(p, extent.center));
	return extent;
}

Box boxOf(const TriangleTree& tree, const Pose& X)
{
	Box box{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
	for (const auto& triangle : tree.triangles())
		for (const Vec3& p : triangle)
		{
			box.lower = componentMin(box.lower, X * p);
			box.upper = componentMax(box.upper, X * p);
		}
	return box;
}

/// A part of a line inside both bodies.
struct Segment
{
	Vec3 begin;
	double length;
};

/// Result of the lines of one direction.
struct Sweep
{
	int axis = 0;
	std::vector<Segment> segments;
	double cellArea = 0;  // area that a line stands for [m^2]
	double length = 0;
	Vec3 moment;  // integral of x along the segments [m^2]
	int unbalanced = 0;
	double volume() const { return cellArea * length; }
};

Vec3 unitVector(int axis)
{
	Vec3 e;
	e[axis] = 1;
	return e;
}

void appendCommon(const std::vector<Interval>& a, const std::vector<Interval>& b, const Interval& range, std::vector<Interval>& out)
{
	size_t i = 0, j = 0;
	while (i < a.size() && j < b.size())
	{
		const double begin = std::max({a[i].begin, b[j].begin, range.begin});
		const double end = std::min({a[i].end, b[j].end, range.end});
		if (begin < end) out.push_back({begin, end});
		if (a[i].end < b[j].end) ++i;
		else ++j;
	}
}

/// Sums over the sample points of one direction.
struct Sums
{
	Wrench normalA, normalB;
	double depthA = 0, depthB = 0;

	void add(const Sums& o)
	{
		normalA = normalA + o.normalA;
		normalB = normalB + o.normalB;
		depthA += o.depthA;
		depthB += o.depthB;
	}
};

/// Standard error of the mean of three vectors.
double standardError(const std::array<Vec3, 3>& v)
{
	const Vec3 mean = (v[0] + v[1] + v[2]) / 3;
	return std::sqrt((squaredNorm(v[0] - mean) + squaredNorm(v[1] - mean) + squaredNorm(v[2] - mean)) / 6);
}
}  // namespace

struct OverlapQuadrature::Implementation
{
	Implementation(const Mesh& a, const Mesh& b) : A(a), B(b), extentA(measure(a)), extentB(measure(b)), boxA(boxOf(A, {})) {}

	Sweep sweep(const Pose& X_AB, const Box& box, int axis, int lines, uint64_t seed) const;
	Box overlapBox(const Pose& X_AB, int lines, uint64_t seed) const;
	Sums sample(const Sweep& sweep, const Pose& X_AB, const Vec3& about, int points, uint64_t seed) const;

	TriangleTree A, B;
	Extent extentA, extentB;
	Box boxA;
};

Sweep OverlapQuadrature::Implementation::sweep(const Pose& X_AB, const Box& box, int axis, int lines, uint64_t seed) const
{
	const int row = (axis + 1) % 3, column = (axis + 2) % 3;
	const Vec3 side = box.size();
	const Pose X_BA = inverse(X_AB);
	Sweep result;
	result.axis = axis;
	result.cellArea = side[row] * side[column] / (static_cast<double>(lines) * lines);
	std::vector<std::vector<Segment>> rows(lines);
	std::vector<int> unbalanced(lines, 0);
#pragma omp parallel for schedule(dynamic)
	for (int r = 0; r < lines; ++r)
	{
		std::seed_seq words{seed, static_cast<uint64_t>(axis), static_cast<uint64_t>(r)};
		std::mt19937 random(words);
		std::uniform_real_distribution<double> jitter(0, 1);
		std::vector<Crossing> crossings;
		std::vector<Interval> insideA, insideB, common;
		for (int c = 0; c < lines; ++c)
		{
			Line line{{}, unitVector(row), unitVector(column), unitVector(axis)};
			line.origin[row] = box.lower[row] + side[row] * (r + jitter(random)) / lines;
			line.origin[column] = box.lower[column] + side[column] * (c + jitter(random)) / lines;
			unbalanced[r] += !A.trace(line, crossings, insideA);
			if (insideA.empty()) continue;
			const Line lineB{X_BA * line.origin, X_BA.rotation * line.u, X_BA.rotation * line.v, X_BA.rotation * line.direction};
			unbalanced[r] += !B.trace(lineB, crossings, insideB);
			common.clear();
			appendCommon(insideA, insideB, {box.lower[axis], box.upper[axis]}, common);
			for (const Interval& i : common) rows[r].push_back({line.origin + i.begin * line.direction, i.end - i.begin});
		}
	}
	for (int r = 0; r < lines; ++r)
	{
		result.unbalanced += unbalanced[r];
		for (const Segment& segment : rows[r])
		{
			result.segments.push_back(segment);
			result.length += segment.length;
			result.moment += segment.length * (segment.begin + 0.5 * segment.length * unitVector(axis));
		}
	}
	return result;
}

/// Intersection of the bodies' boxes. With many lines to come, it is narrowed to the result of a coarse sweep plus two of its cells.
Box OverlapQuadrature::Implementation::overlapBox(const Pose& X_AB, int lines, uint64_t seed) const
{
	const Box boxB = boxOf(B, X_AB);
	const Box whole{componentMax(boxA.lower, boxB.lower), componentMin(boxA.upper, boxB.upper)};
	const Vec3 side = whole.size();
	constexpr int kCoarse = 64;
	if (lines < kCoarse || side.x <= 0 || side.y <= 0 || side.z <= 0) return whole;
	Box found{whole.upper, whole.lower};
	for (int axis = 0; axis < 3; ++axis)
		for (const Segment& segment : sweep(X_AB, whole, axis, kCoarse, seed + 7919).segments)
		{
			found.lower = componentMin(found.lower, segment.begin);
			found.upper = componentMax(found.upper, segment.begin + segment.length * unitVector(axis));
		}
	if (found.size().x < 0) return whole;
	const Vec3 margin = side * (2.0 / kCoarse);
	return {componentMax(whole.lower, found.lower - margin), componentMin(whole.upper, found.upper + margin)};
}

/// Sample points, one in each of equal strata of the concatenated segments. The places in the strata follow a golden-ratio sequence.
/// Neighbouring lines are therefore sampled at different heights, even when each has only one stratum.
std::vector<Vec3> strataPoints(const Sweep& sweep, int points, uint64_t seed)
{
	constexpr double kGolden = 0.6180339887498949;
	std::vector<Vec3> positions;
	std::mt19937_64 random(seed);
	double place = std::uniform_real_distribution<double>(0, 1)(random);
	const double stratum = sweep.length / points;
	double begin = 0, next = place * stratum;
	for (const Segment& segment : sweep.segments)
	{
		const double end = begin + segment.length;
		while (next < end && static_cast<int>(positions.size()) < points)
		{
			positions.push_back(segment.begin + (next - begin) * unitVector(sweep.axis));
			place += place + kGolden < 1 ? kGolden : kGolden - 1;
			next = (static_cast<double>(positions.size()) + place) * stratum;
		}
		begin = end;
	}
	return positions;
}

Sums OverlapQuadrature::Implementation::sample(const Sweep& sweep, const Pose& X_AB, const Vec3& about, int points, uint64_t seed) const
{
	const std::vector<Vec3> positions = strataPoints(sweep, points, seed);
	const Pose X_BA = inverse(X_AB);
	constexpr int kChunk = 256;
	const int chunks = (static_cast<int>(positions.size()) + kChunk - 1) / kChunk;
	std::vector<Sums> partial(chunks);
#pragma omp parallel for schedule(dynamic)
	for (int chunk = 0; chunk < chunks; ++chunk)
	{
		const size_t end = std::min(positions.size(), static_cast<size_t>(chunk + 1) * kChunk);
		for (size_t i = static_cast<size_t>(chunk) * kChunk; i < end; ++i)
		{
			const Vec3& p = positions[i];
			const Vec3 pB = X_BA * p;
			const Nearest a = A.nearest(p), b = B.nearest(pB);
			const Vec3 nA = normalized(a.point - p), nB = X_AB.rotation * normalized(b.point - pB);
			partial[chunk].add({{nA, cross(p - about, nA)}, {nB, cross(p - about, nB)}, a.distance, b.distance});
		}
	}
	Sums sums;
	for (const Sums& s : partial) sums.add(s);
	const double weight = positions.empty() ? 0 : sweep.volume() / static_cast<double>(positions.size());
	return {weight * sums.normalA, weight * sums.normalB, weight * sums.depthA, weight * sums.depthB};
}

OverlapQuadrature::OverlapQuadrature(const Mesh& A, const Mesh& B) : m_impl(std::make_unique<Implementation>(A, B)) {}
OverlapQuadrature::~OverlapQuadrature() = default;
OverlapQuadrature::OverlapQuadrature(OverlapQuadrature&&) noexcept = default;

const OverlapQuadrature::Extent& OverlapQuadrature::extentA() const { return m_impl->extentA; }
const OverlapQuadrature::Extent& OverlapQuadrature::extentB() const { return m_impl->extentB; }

QuadratureTruth OverlapQuadrature::integrate(const Pose& X_AB, const Vec3& about, int linesPerAxis, int pointsTotal, uint64_t seed) const
{
	QuadratureTruth truth;
	const Box box = m_impl->overlapBox(X_AB, linesPerAxis, seed);
	const Vec3 side = box.size();
	if (side.x <= 0 || side.y <= 0 || side.z <= 0) return truth;
	std::array<Vec3, 3> volumes, forces;
	Sums sums;
	Vec3 moment;
	for (int axis = 0; axis < 3; ++axis)
	{
		const Sweep sweep = m_impl->sweep(X_AB, box, axis, linesPerAxis, seed);
		truth.unbalancedLines += sweep.unbalanced;
		truth.volume += sweep.volume() / 3;
		volumes[axis] = {sweep.volume(), 0, 0};
		moment += sweep.cellArea * sweep.moment;
		if (pointsTotal <= 0) continue;
		const Sums found = m_impl->sample(sweep, X_AB, about, std::max(1, pointsTotal / 3), seed + 31 * (axis + 1));
		forces[axis] = 0.5 * (found.normalB.force - found.normalA.force);
		sums.add(found);
	}
	truth.volumeError = standardError(volumes);
	truth.normalError = standardError(forces);
	truth.normalA = (1.0 / 3) * sums.normalA;
	truth.normalB = (1.0 / 3) * sums.normalB;
	truth.depthA = sums.depthA / 3;
	truth.depthB = sums.depthB / 3;
	if (truth.volume > 0) truth.centroid = moment / (3 * truth.volume);
	return truth;
}
}  // namespace scenes
