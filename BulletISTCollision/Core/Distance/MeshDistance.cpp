// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include "BulletISTCollision/Core/Distance/RayCrossings.h"
#include "BulletISTCollision/Core/Distance/WideTriangleBvh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace ist
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();
[[maybe_unused]] constexpr size_t kFewestToShare = 4096;  // smallest number of triangles that threads share
// A cluster counts as far beyond this many radii (Barill et al. 2018 use 2 and one more order). To distinguish inside from outside, a
// smaller factor is enough. The largest error seen was 0.03 with 2.5, and 0.007 with 5.
constexpr double kFarRadiiSide = 2.5;
constexpr double kFarRadii = 5;

using Nearest = WideTriangleBvh::Nearest;
using Child = TriangleHierarchy::Child;

/// Sum of the solid angles of triangles seen from a point, positive from behind. It needs one arc tangent for all of them: the tangents of
/// half the angles (van Oosterom and Strackee 1983) are those of complex numbers, and these are multiplied.
class SolidAngles
{
public:
	void add(const PreparedTriangle& t, const Vec3& p)
	{
		const Vec3 a = t.a - p, b = a + t.ab, c = a + t.ac;
		const double la = norm(a), lb = norm(b), lc = norm(c);
		// a . (ab x ac) equals a . (b x c) and loses fewer digits far from the triangle.
		const double numerator = dot(a, t.normal);
		if (numerator != 0) multiply(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb, numerator);
	}
	/// To be called after a few triangles, so that the product stays in the range of numbers.
	void rescale()
	{
		const double size = std::fabs(m_re) + std::fabs(m_im);
		if (!(size > 0)) return;
		m_re /= size;
		m_im /= size;
	}
	double sum() const { return 2 * (std::atan2(m_im + 0.0, m_re) + 2 * std::numbers::pi * double(m_turns)); }

private:
	/// `im` is not 0.
	void multiply(double re, double im)
	{
		const double newRe = m_re * re - m_im * im, newIm = m_re * im + m_im * re;
		// The sum of two angles of one sign has passed a half turn if the sign of its sine is the other one.
		if (m_im >= 0 && im > 0 && newIm < 0) ++m_turns;
		if (m_im < 0 && im < 0 && (newIm > 0 || (newIm == 0 && newRe < 0))) --m_turns;
		m_re = newRe;
		m_im = newIm;
	}
	double m_re = 1, m_im = 0;
	int64_t m_turns = 0;
};

struct Cluster
{
	Vec3 centroid, areaNormal;
	// Symmetric part of the integral of n (x - centroid)^T: the diagonal, and the sums m12 + m21, m20 + m02, m01 + m10.
	Vec3 momentDiagonal, momentMixed;
	double radius2 = 0;
};

/// Solid angle of a far cluster, `r` = centroid - p: the integral of n . g(x - p), g(r) = r / |r|^3, to first order of g about r.
inline double farSolidAngle(const Cluster& c, const Vec3& r, double r2)
{
	const Vec3 &d = c.momentDiagonal, &m = c.momentMixed;
	const double trace = d.x + d.y + d.z;
	const double quadratic = d.x * r.x * r.x + d.y * r.y * r.y + d.z * r.z * r.z + m.x * r.y * r.z + m.y * r.z * r.x + m.z * r.x * r.y;
	return (dot(c.areaNormal, r) + trace - 3 * quadratic / r2) / (r2 * std::sqrt(r2));
}

}  // namespace

struct MeshDistance::Implementation
{
	Mesh mesh;
	// All coordinates below are relative to this point, so that distance from the origin costs no digits.
	Vec3 origin;
	double size = 0;
	TriangleHierarchy hierarchy;
	WideTriangleBvh bvh;
	RayCrossings crossings;
	Cluster rootCluster;
	std::vector<std::array<Cluster, 2>> clusters;  // clusters of hierarchy.nodes[i].child

	Implementation(Mesh source, int threads);
	void addClusters();
	Cluster clusterOf(const Child& child, uint32_t begin, uint32_t end) const;
	Field fieldFrom(const Nearest& c, bool inside) const;
	double winding(const Vec3& p, double farRadii) const;
	bool contains(const Vec3& p) const;
};

MeshDistance::Implementation::Implementation(Mesh source, int threads) : mesh(std::move(source))
{
	if (mesh.triangles.empty()) return;
	Vec3 lower = mesh.vertices[mesh.triangles[0][0]], upper = lower;
	for (const auto& t : mesh.triangles)
	{
		for (const uint32_t v : t)
		{
			lower = componentMin(lower, mesh.vertices[v]);
			upper = componentMax(upper, mesh.vertices[v]);
		}
	}
	origin = (lower + upper) * 0.5;
	size = norm(upper - lower);
	hierarchy = TriangleHierarchy(mesh, origin, threads);
	const Result<InstructionSet> set = chosenInstructionSet();
#pragma omp parallel num_threads(threads) if (mesh.triangles.size() >= kFewestToShare)
#pragma omp single
	{
#pragma omp task
		crossings = RayCrossings(mesh, origin);
		bvh = WideTriangleBvh(hierarchy, size, set ? set.value() : bestInstructionSet());
		addClusters();
	}
}

/// The threads of a surrounding parallel region share the work.
void MeshDistance::Implementation::addClusters()
{
	clusters.resize(hierarchy.nodes.size());
#pragma omp taskloop grainsize(64) default(shared)
	for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(clusters.size()); ++i)
	{
		for (int k = 0; k < 2; ++k)
		{
			const Child& child = hierarchy.nodes[size_t(i)].child[k];
			const auto [begin, end] = hierarchy.range(child);
			clusters[size_t(i)][size_t(k)] = clusterOf(child, begin, end);
		}
	}
	rootCluster = clusterOf(hierarchy.root, 0, uint32_t(hierarchy.triangles.size()));
}

Cluster MeshDistance::Implementation::clusterOf(const Child& child, uint32_t begin, uint32_t end) const
{
	const std::vector<PreparedTriangle>& triangles = hierarchy.triangles;
	Cluster c;
	double area = 0;
	for (uint32_t i = begin; i < end; ++i)
	{
		const PreparedTriangle& t = triangles[i];
		const double triangleArea = norm(t.normal) / 2;
		c.areaNormal += t.normal * 0.5;
		c.centroid += (t.a + (t.ab + t.ac) / 3) * triangleArea;
		area += triangleArea;
	}
	c.centroid = area > 0 ? c.centroid / area : (child.lower + child.upper) * 0.5;
	for (uint32_t i = begin; i < end; ++i)
	{
		const PreparedTriangle& t = triangles[i];
		const Vec3 a = t.a - c.centroid;
		const Vec3 n = t.normal * 0.5, m = a + (t.ab + t.ac) / 3;
		c.momentDiagonal += componentProduct(n, m);
		c.momentMixed += {n.y * m.z + n.z * m.y, n.z * m.x + n.x * m.z, n.x * m.y + n.y * m.x};
		c.radius2 = std::max({c.radius2, squaredNorm(a), squaredNorm(a + t.ab), squaredNorm(a + t.ac)});
	}
	return c;
}

double MeshDistance::Implementation::winding(const Vec3& p, double farRadii) const
{
	if (hierarchy.triangles.empty()) return 0;
	const double far2 = farRadii * farRadii;
	double sum = 0;
	SolidAngles near;
	std::pair<const Child*, const Cluster*> stack[TriangleHierarchy::kMostLevels + 2];
	int top = 0;
	stack[top++] = {&hierarchy.root, &rootCluster};
	while (top > 0)
	{
		const auto [child, cluster] = stack[--top];
		const Vec3 r = cluster->centroid - p;
		const double r2 = squaredNorm(r);
		if (r2 > far2 * cluster->radius2) sum += farSolidAngle(*cluster, r, r2);
		else if (child->count > 0)
		{
			for (uint32_t i = child->first; i < child->first + child->count; ++i) near.add(hierarchy.triangles[i], p);
			near.rescale();
		}
		else
			for (int k = 0; k < 2; ++k) stack[top++] = {&hierarchy.nodes[child->first].child[k], &clusters[child->first][k]};
	}
	return (sum + near.sum()) / (4 * std::numbers::pi);
}

bool MeshDistance::Implementation::contains(const Vec3& p) const
{
	if (hierarchy.triangles.empty() || squaredDistance(hierarchy.root, p) > 0) return false;
	if (crossings.isUsable())
		if (const std::optional<int> whole = crossings.windingNumber(p)) return *whole > 0;
	double w = winding(p, kFarRadiiSide);
	if (std::fabs(w - 0.5) < 0.1) w = winding(p, kFarRadii);
	return w > 0.5;
}

Vec3 closestPointOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
	const PreparedTriangle t = prepareTriangle(a, b, c, 0);
	double d2;
	return p + offsetToTriangle(t, a - p, d2);
}

MeshDistance::MeshDistance(Mesh mesh, int threads) : m_impl(std::make_unique<Implementation>(std::move(mesh), threads)) {}
MeshDistance::~MeshDistance() = default;
MeshDistance::MeshDistance(MeshDistance&&) noexcept = default;
MeshDistance& MeshDistance::operator=(MeshDistance&&) noexcept = default;

const Mesh& MeshDistance::mesh() const { return m_impl->mesh; }

MeshDistance::Closest MeshDistance::closest(const Vec3& p, double upperBound) const
{
	const Nearest n = m_impl->bvh.nearest(p - m_impl->origin, upperBound);
	if (n.triangle == WideTriangleBvh::kNone) return {p, upperBound, WideTriangleBvh::kNone};
	return {p + n.offset, std::sqrt(n.distance2), n.triangle};
}

bool MeshDistance::within(const Vec3& p, double reach, size_t most, std::vector<std::pair<double, uint32_t>>& out) const
{
	const bool all = m_impl->bvh.within(p - m_impl->origin, reach, most, out);
	for (auto& [distance, triangle] : out) triangle = m_impl->hierarchy.triangles[triangle].index;
	return all;
}

double MeshDistance::windingNumber(const Vec3& p) const { return m_impl->winding(p - m_impl->origin, kFarRadii); }

bool MeshDistance::contains(const Vec3& p) const { return m_impl->contains(p - m_impl->origin); }

double MeshDistance::signedDistance(const Vec3& p) const
{
	const double d = closest(p).distance;
	return contains(p) ? -d : d;
}

MeshDistance::Field MeshDistance::field(const Vec3& p) const { return field(p, contains(p)); }

MeshDistance::Field MeshDistance::field(const Vec3& p, bool inside) const
{
	return m_impl->fieldFrom(m_impl->bvh.nearest(p - m_impl->origin, kInfinity), inside);
}

MeshDistance::Field MeshDistance::field(const Vec3& p, bool inside, uint32_t& hint) const
{
	const Nearest n = m_impl->bvh.nearest(p - m_impl->origin, kInfinity, hint);
	hint = n.place;
	return m_impl->fieldFrom(n, inside);
}

MeshDistance::Field MeshDistance::Implementation::fieldFrom(const Nearest& c, bool inside) const
{
	const double distance = std::sqrt(c.distance2);
	Field f{inside ? distance : -distance, {0, 0, 1}};
	if (c.triangle == WideTriangleBvh::kNone) return f;
	if (distance >= 1e-12 * size && distance > 0)
	{
		f.normal = normalized(inside ? c.offset : -c.offset);
		return f;
	}
	const auto& t = mesh.triangles[c.triangle];
	const Vec3 a = mesh.vertices[t[0]];
	const Vec3 n = normalized(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
	if (squaredNorm(n) > 0) f.normal = n;
	return f;
}
}  // namespace ist
