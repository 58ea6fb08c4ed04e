// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Leaves/Cells.h"

#include "BulletISTCollision/Core/Leaves/CellSplitter.h"
#include "BulletISTCollision/Core/Leaves/NearestSphere.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numbers>
#include <random>
#include <string>

namespace ist
{
namespace
{
using Polygon = std::vector<Vec3>;
using Polyhedron = std::vector<Polygon>;

Polyhedron polyhedron(const Mesh& mesh)
{
	Polyhedron result;
	for (const auto& t : mesh.triangles) result.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
	return result;
}

/// The part of a convex polyhedron where dot(n, x) <= d.
Polyhedron clipped(const Polyhedron& body, const Vec3& n, double d)
{
	Polyhedron result;
	Polygon cap;
	for (const Polygon& face : body)
	{
		Polygon kept;
		for (size_t i = 0; i < face.size(); ++i)
		{
			const Vec3 &p = face[i], &q = face[(i + 1) % face.size()];
			const double a = dot(n, p) - d, b = dot(n, q) - d;
			if (a <= 0) kept.push_back(p);
			if ((a <= 0) == (b <= 0)) continue;
			kept.push_back(p + (q - p) * (a / (a - b)));
			cap.push_back(kept.back());
		}
		if (kept.size() >= 3) result.push_back(kept);
	}
	if (cap.size() >= 3)
	{
		Vec3 middle, u, v;
		for (const Vec3& p : cap) middle += p / double(cap.size());
		completeFrame(normalized(n), u, v);
		const auto angle = [&](const Vec3& p) { return std::atan2(dot(p - middle, v), dot(p - middle, u)); };
		std::sort(cap.begin(), cap.end(), [&](const Vec3& a, const Vec3& b) { return angle(a) < angle(b); });
		result.push_back(cap);
	}
	return result;
}

struct Truth
{
	double volume = 0;
	Vec3 centroid;
	SymmetricMatrix3 second;  ///< Int (x - centroid) (x - centroid)^T dV
};

/// Sums over tetrahedra with a corner at the origin.
Truth momentsOf(const Polyhedron& body)
{
	Truth sum;
	for (const Polygon& face : body)
		for (size_t i = 1; i + 1 < face.size(); ++i)
		{
			const Vec3 &a = face[0], &b = face[i], &c = face[i + 1], corners = a + b + c;
			const double v = dot(a, cross(b, c)) / 6;
			sum.volume += v;
			sum.centroid += corners * (v / 4);
			const SymmetricMatrix3 squares = SymmetricMatrix3::square(a) + SymmetricMatrix3::square(b) + SymmetricMatrix3::square(c);
			sum.second += (squares + SymmetricMatrix3::square(corners)) * (v / 20);
		}
	sum.centroid *= 1 / sum.volume;
	sum.second += SymmetricMatrix3::square(sum.centroid) * -sum.volume;
	return sum;
}

double mass(const MomentEllipsoid& b) { return double(b.density) * 4.0 / 3.0 * std::numbers::pi * double(b.R) * b.R * b.R; }

/// Spheres at random places with the radius `radius()`, where they fit.
template <class Radius> SpherePacking randomPacking(const MeshDistance& surface, size_t count, std::mt19937& generator, Radius radius)
{
	const Box box = bounds(surface.mesh());
	std::uniform_real_distribution<double> uniform(0, 1);
	SpherePacking packing;
	while (packing.spheres.size() < count)
	{
		const Vec3 size = box.size();
		const Sphere s{float(box.lower.x + uniform(generator) * size.x), float(box.lower.y + uniform(generator) * size.y),
			float(box.lower.z + uniform(generator) * size.z), float(radius())};
		if (surface.signedDistance(s.center()) > -s.r - 1e-6) continue;
		const auto clash = [&](const Sphere& o) { return distance(o.center(), s.center()) <= double(o.r) + s.r + 1e-6; };
		if (std::none_of(packing.spheres.begin(), packing.spheres.end(), clash)) packing.spheres.push_back(s);
	}
	return packing;
}

/// Second moment about `center`.
SymmetricMatrix3 secondMoment(const MomentEllipsoid& e, const Vec3& center)
{
	return (e.shape() * 0.2 + SymmetricMatrix3::square(e.center() - center)) * mass(e);
}

void expectNear(const SymmetricMatrix3& a, const SymmetricMatrix3& b, double tolerance, size_t cell)
{
	const SymmetricMatrix3 off = a + b * -1;
	for (double v : {off.xx, off.yy, off.zz, off.xy, off.xz, off.yz}) EXPECT_NEAR(v, 0, tolerance) << "cell " << cell;
}

/// The tolerance is four standard deviations of a sum over independent points, for the fewest points that the library uses (1e5 in the
/// gap). Stratification only makes the error smaller.
void expectCellsNear(const Cells& cells, const SpherePacking& packing, const std::vector<Truth>& truth, double meshVolume)
{
	double balls = 0;
	for (const Sphere& s : packing.spheres) balls += 4.0 / 3.0 * std::numbers::pi * std::pow(double(s.r), 3);
	const double volumePerPoint = (meshVolume - balls) / 1e5;
	ASSERT_EQ(cells.cells.size(), truth.size());
	for (size_t i = 0; i < truth.size(); ++i)
	{
		const MomentEllipsoid& cell = cells.cells[i];
		const double gap = truth[i].volume - 4.0 / 3.0 * std::numbers::pi * std::pow(double(packing.spheres[i].r), 3);
		const double sigma = volumePerPoint * std::sqrt(gap / volumePerPoint);
		EXPECT_NEAR(mass(cell), truth[i].volume, 4 * sigma) << "cell " << i;
		const double spread = std::sqrt(0.6) * cell.R;
		EXPECT_LT(distance(cell.center(), truth[i].centroid), 4 * sigma * spread / truth[i].volume) << "cell " << i;
		EXPECT_LT(4 * sigma, 0.15 * truth[i].volume) << "the tolerance says nothing, cell " << i;
		// Nearly all points of a cell lie within its bounding radius.
		const double momentTolerance = 4 * sigma * cell.R * cell.R;
		expectNear(secondMoment(cell, truth[i].centroid), truth[i].second, momentTolerance, i);
		EXPECT_LT(momentTolerance, 0.4 * truth[i].second.trace()) << "the tolerance says nothing, cell " << i;
		SymmetricMatrix3 ofLeaves;
		for (const MomentEllipsoid& leaf : cells.leaves)
			if (leaf.sphere == i) ofLeaves += secondMoment(leaf, truth[i].centroid);
		expectNear(ofLeaves, truth[i].second, momentTolerance, i);
		EXPECT_EQ(cell.sphere, i);
	}
}

void expectConsistent(const Cells& cells, double meshVolume)
{
	double total = 0, leafTotal = 0;
	std::vector<double> ofLeaves(cells.cells.size());
	std::vector<Vec3> firstMoment(cells.cells.size());
	for (const MomentEllipsoid& c : cells.cells) total += mass(c);
	for (const MomentEllipsoid& l : cells.leaves)
	{
		leafTotal += mass(l);
		ofLeaves[l.sphere] += mass(l);
		firstMoment[l.sphere] += l.center() * mass(l);
		EXPECT_LE(norm(l.normal()), 1 + 1e-6);
		EXPECT_GT(l.R, 0);
	}
	EXPECT_NEAR(total, meshVolume, 1e-6 * meshVolume);
	EXPECT_NEAR(leafTotal, meshVolume, 1e-6 * meshVolume);
	for (size_t i = 0; i < ofLeaves.size(); ++i)
	{
		EXPECT_NEAR(ofLeaves[i], mass(cells.cells[i]), 1e-6 * mass(cells.cells[i]));
		EXPECT_LT(distance(firstMoment[i] / ofLeaves[i], cells.cells[i].center()), 1e-4 * cells.cells[i].R);
	}
}

void expectVoronoi(const Mesh& mesh, double radius, size_t count, unsigned seed)
{
	const MeshDistance surface(mesh);
	std::mt19937 generator(seed);
	const SpherePacking packing = randomPacking(surface, count, generator, [&] { return radius; });
	const auto cells = buildCells(surface, packing, {});
	ASSERT_TRUE(cells) << cells.error().message;
	std::vector<Truth> truth;
	double total = 0;
	for (const Sphere& s : packing.spheres)
	{
		Polyhedron cell = polyhedron(mesh);
		for (const Sphere& o : packing.spheres)
		{
			const Vec3 n = o.center() - s.center();
			if (squaredNorm(n) > 0) cell = clipped(cell, n, dot(n, (s.center() + o.center()) * 0.5));
		}
		truth.push_back(momentsOf(cell));
		total += truth.back().volume;
	}
	const double meshVolume = massProperties(mesh).volume;
	ASSERT_NEAR(total, meshVolume, 1e-9 * meshVolume);
	expectCellsNear(cells.value(), packing, truth, meshVolume);
	expectConsistent(cells.value(), meshVolume);
}

SpherePacking inscribedBall(const MeshDistance& surface)
{
	SpherePacking packing;
	packing.spheres.push_back({0, 0, 0, float(surface.closest({0, 0, 0}).distance * (1 - 1e-6))});
	return packing;
}
}  // namespace

TEST(NearestSphere, AgreesWithASearchThroughAllSpheres)
{
	std::mt19937 generator(4);
	std::uniform_real_distribution<double> uniform(-0.5, 0.5);
	const MeshDistance surface(makeBoxMesh({0.5, 0.5, 0.5}));
	const SpherePacking packing = randomPacking(
		surface, 300, generator, [&] { return 0.01 * std::exp(4.0 * std::max(-0.4, uniform(generator))); });
	const NearestSphere tree(packing.spheres);
	int complete = 0, incomplete = 0;
	for (int k = 0; k < 3000; ++k)
	{
		const Vec3 p{2 * uniform(generator), 2 * uniform(generator), 2 * uniform(generator)};
		uint32_t nearest = 0;
		double least = 1e300;
		for (uint32_t i = 0; i < packing.spheres.size(); ++i)
		{
			const double d = distance(p, packing.spheres[i].center()) - packing.spheres[i].r;
			if (d < least) least = d, nearest = i;
		}
		EXPECT_EQ(tree.nearest(p).sphere, nearest);
		EXPECT_EQ(tree.nearest(p).distance, least);
		EXPECT_EQ(tree.nearest(p, uint32_t(k) % 300).sphere, nearest);

		NearestSphere::Neighbourhood near;
		const Vec3 offset{uniform(generator), uniform(generator), uniform(generator)};
		const double share = k % 2 ? 0.3 : 3;
		tree.gather(p + offset * share, norm(offset) * share, near);
		EXPECT_EQ(tree.nearest(p, near).sphere, nearest);
		EXPECT_EQ(tree.nearest(p, near).distance, least);
		++(near.complete ? complete : incomplete);
	}
	EXPECT_GT(complete, 500);
	EXPECT_GT(incomplete, 500);
}

TEST(Cells, OfEqualSpheresInABoxAreVoronoiCells) { expectVoronoi(makeBoxMesh({0.5, 0.4, 0.3}), 0.05, 40, 1); }

TEST(Cells, OfEqualSpheresInATetrahedronAreVoronoiCells) { expectVoronoi(makeTetrahedronMesh(1), 0.04, 25, 2); }

TEST(Cells, OfUnequalSpheresAgreeWithAGrid)
{
	const MeshDistance surface(makeBoxMesh({0.5, 0.5, 0.5}));
	std::mt19937 generator(3);
	std::uniform_real_distribution<double> uniform(0.03, 0.2);
	const SpherePacking packing = randomPacking(surface, 12, generator, [&] { return uniform(generator); });
	const auto cells = buildCells(surface, packing, {});
	ASSERT_TRUE(cells);

	constexpr int n = 160;
	std::vector<Truth> truth(packing.spheres.size());
	for (int i = 0; i < n * n * n; ++i)
	{
		const Vec3 p{(i % n + 0.5) / n - 0.5, (i / n % n + 0.5) / n - 0.5, (i / n / n + 0.5) / n - 0.5};
		size_t owner = 0;
		double least = 1e300;
		for (size_t k = 0; k < packing.spheres.size(); ++k)
		{
			const double d = distance(p, packing.spheres[k].center()) - packing.spheres[k].r;
			if (d < least) least = d, owner = k;
		}
		truth[owner].volume += 1.0 / (double(n) * n * n);
		truth[owner].centroid += p;
		truth[owner].second += SymmetricMatrix3::square(p) * (1.0 / (double(n) * n * n));
	}
	for (Truth& t : truth)
	{
		t.centroid *= 1 / (t.volume * n * n * n);
		t.second += SymmetricMatrix3::square(t.centroid) * -t.volume;
	}
	expectCellsNear(cells.value(), packing, truth, 1);
	expectConsistent(cells.value(), 1);
}

TEST(Cells, OneBallInASphereIsSplitIntoLeavesThatPointOutwards)
{
	const MeshDistance surface(makeSphereMesh(1, 3));
	const auto cells = buildCells(surface, inscribedBall(surface), {});
	ASSERT_TRUE(cells);
	ASSERT_EQ(cells.value().cells.size(), 1u);
	EXPECT_LT(norm(cells.value().cells[0].normal()), 0.02);
	EXPECT_NEAR(cells.value().cells[0].depth, 0.25, 0.01);
	ASSERT_EQ(cells.value().leaves.size(), 300u);
	expectConsistent(cells.value(), massProperties(surface.mesh()).volume);
	double meanLength = 0, alignment = 0, meanDepth = 0;
	for (const MomentEllipsoid& l : cells.value().leaves)
	{
		meanLength += mass(l) * norm(l.normal());
		alignment += mass(l) * dot(l.normal(), normalized(l.center()));
		meanDepth += mass(l) * l.depth;
	}
	const double volume = massProperties(surface.mesh()).volume;
	EXPECT_GT(meanLength / volume, 0.9);
	EXPECT_GT(alignment / meanLength, 0.98);
	EXPECT_NEAR(meanDepth / volume, cells.value().cells[0].depth, 1e-3);
}

TEST(Cells, LeafUnderAFlatFaceHasItsNormal)
{
	const MeshDistance surface(makeBoxMesh({0.5, 0.5, 0.5}));
	const auto cells = buildCells(surface, inscribedBall(surface), {});
	ASSERT_TRUE(cells);
	int tested = 0;
	for (const MomentEllipsoid& l : cells.value().leaves)
	{
		if (l.z < 0.38 || std::fabs(l.x) > 0.2 || std::fabs(l.y) > 0.2) continue;
		++tested;
		EXPECT_GT(l.nz, 0.99);
		EXPECT_NEAR(l.depth, 0.5 - l.z, 2e-3);
	}
	EXPECT_GT(tested, 3);
}

TEST(Cells, MeasureTheGapsOfASurface)
{
	// A bar is filled by a row of balls, except for the last one, so its far end is uncovered.
	const Vec3 half{4, 0.5, 0.5};
	const MeshDistance surface(makeBoxMesh(half));
	SpherePacking packing;
	for (int i = 0; i < 7; ++i) packing.spheres.push_back({float(i) - 3.5f, 0, 0, 0.4999f});
	const auto cells = buildCells(surface, packing, {});
	ASSERT_TRUE(cells);

	std::vector<std::pair<double, double>> gaps;  // (gap, area)
	constexpr int n = 300;
	for (int face = 0; face < 6; ++face)
		for (int i = 0; i < n * n; ++i)
		{
			const int a = face / 2, u = (a + 1) % 3, v = (a + 2) % 3;
			Vec3 p;
			p[a] = face % 2 ? half[a] : -half[a];
			p[u] = half[u] * (2 * (i % n + 0.5) / n - 1);
			p[v] = half[v] * (2 * (i / n + 0.5) / n - 1);
			double gap = 1e300;
			for (const Sphere& s : packing.spheres) gap = std::min(gap, distance(p, s.center()) - s.r);
			gaps.push_back({gap, 4 * half[u] * half[v] / (n * n)});
		}
	double area = 0, mean = 0, uncovered = 0;
	for (const auto& [gap, weight] : gaps) area += weight, mean += gap * weight;
	mean /= area;
	for (const auto& [gap, weight] : gaps)
		if (gap > 3 * mean) uncovered += weight / area;
	EXPECT_GT(uncovered, 0.02);
	EXPECT_NEAR(cells.value().meanGap, mean, 1e-3 * mean);
	EXPECT_NEAR(cells.value().uncoveredArea, uncovered, 2e-3);
	const double corner = norm({1.5, 0.5, 0.5}) - 0.4999;
	EXPECT_GE(cells.value().maxGap, corner - 1e-6);
	EXPECT_LE(cells.value().maxGap, 1.011 * corner);
}

TEST(Cells, DoNotDependOnTheNumberOfThreadsOnlyOnTheSeed)
{
	const MeshDistance surface(makeTorusMesh(1, 0.3, 48, 24));
	std::mt19937 generator(5);
	const SpherePacking packing = randomPacking(surface, 250, generator, [] { return 0.05; });
	CellOptions options;
	options.threads = 1;
	const auto one = buildCells(surface, packing, options);
	options.threads = 3;
	const auto three = buildCells(surface, packing, options);
	options.seed = 2;
	const auto other = buildCells(surface, packing, options);
	ASSERT_TRUE(one && three && other);
	const auto same = [](const std::vector<MomentEllipsoid>& a, const std::vector<MomentEllipsoid>& b) {
		return std::equal(a.begin(), a.end(), b.begin(), b.end(),
			[](const MomentEllipsoid& p, const MomentEllipsoid& q) { return std::memcmp(&p, &q, sizeof p) == 0; });
	};
	EXPECT_TRUE(same(one.value().cells, three.value().cells));
	EXPECT_TRUE(same(one.value().leaves, three.value().leaves));
	EXPECT_EQ(one.value().meanGap, three.value().meanGap);
	EXPECT_EQ(one.value().maxGap, three.value().maxGap);
	EXPECT_FALSE(same(one.value().leaves, other.value().leaves));
	EXPECT_EQ(one.value().leaves.size(), 375u);
	expectConsistent(one.value(), massProperties(surface.mesh()).volume);
}

TEST(Cells, RefuseWhatCannotBeAPackingOfTheMesh)
{
	const MeshDistance surface(makeBoxMesh({0.5, 0.5, 0.5}));
	const auto message = [&](const std::vector<Sphere>& spheres) {
		const auto result = buildCells(surface, {spheres, 0}, {});
		return result ? std::string() : result.error().message;
	};
	EXPECT_NE(message({}).find("no spheres"), std::string::npos);
	EXPECT_NE(message({{0, 0, 0, 0}}).find("Sphere 0"), std::string::npos);
	EXPECT_NE(message({{0, 0, 0, 2}}).find("more volume"), std::string::npos);
}

TEST(Cells, StopWhenTheCallbackSaysSo)
{
	const MeshDistance surface(makeBoxMesh({0.5, 0.5, 0.5}));
	for (const double stopAt : {0.0, 0.3, 0.9})
	{
		CellOptions options;
		options.progress = [&](const char* stage, double fraction) {
			EXPECT_EQ(std::string(stage), "cells");
			return fraction < stopAt;
		};
		const auto result = buildCells(surface, inscribedBall(surface), options);
		ASSERT_FALSE(result);
		EXPECT_TRUE(result.error().cancelled);
	}
}
}  // namespace ist
