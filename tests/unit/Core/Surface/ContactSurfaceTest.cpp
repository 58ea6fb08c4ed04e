// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/ContactSurface.h"

#include "BulletISTCollision/Core/Base/CounterRandom.h"
#include "BulletISTCollision/Core/Mesh/MeshDivision.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/JoinedMesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <numbers>

namespace ist
{
namespace
{
ContactSurface surfaceOf(const Mesh& mesh, int64_t elements)
{
	ContactSurfaceOptions options;
	options.elements = elements;
	auto result = buildContactSurface(mesh, options);
	EXPECT_TRUE(result);
	if (!result) return {};
	EXPECT_EQ(result.value().validate(), "");
	return std::move(result).value();
}

/// The shape of an element at the parameters (s, t), as the header defines it.
struct SheetPoint
{
	Vec3 position, normal;

	SheetPoint(const SurfaceElement& e, double s, double t)
	{
		const Vec3 e1 = toVec3(e.e1), e2 = toVec3(e.e2);
		const double height = (e.k11 + e.k22) / 6 - (e.k11 * s * s + 2 * e.k12 * s * t + e.k22 * t * t) / 2;
		position = toVec3(e.center) + e1 * s + e2 * t + normalized(toVec3(e.normal)) * height;
		normal = toVec3(e.normal);
		if (e.isTriangle) return;
		const Vec3 plane = cross(e1, e2), d1 = cross(e2, plane) / squaredNorm(plane), d2 = cross(plane, e1) / squaredNorm(plane);
		normal += d1 * (e.k11 * s + e.k12 * t) + d2 * (e.k12 * s + e.k22 * t);
	}
};

/// Calls visit(point, area) for the Gauss points of an element.
template <class Visit> void eachGaussPoint(const SurfaceElement& e, Visit visit)
{
	if (e.isTriangle) return visit(SheetPoint(e, 1 / 3.0, 1 / 3.0), double(e.area));
	const double g = 1 / std::sqrt(3.0);
	for (const double s : {-g, g})
		for (const double t : {-g, g}) visit(SheetPoint(e, s, t), e.area / 4.0);
}

/// Volume by the divergence theorem.
double volumeOf(const ContactSurface& surface, const Vec3& origin)
{
	double sum = 0;
	for (const SurfaceElement& e : surface.elements)
		eachGaussPoint(e, [&](const SheetPoint& p, double area) { sum += area * dot(p.position - origin, p.normal) / 3; });
	return sum;
}

Mesh scaled(Mesh mesh, const Vec3& factor)
{
	for (Vec3& v : mesh.vertices) v = {v.x * factor.x, v.y * factor.y, v.z * factor.z};
	return mesh;
}

/// A mesh turned and moved, so that nothing lies along an axis.
Mesh placed(const Mesh& mesh, uint64_t seed)
{
	CounterRandom random(seed, 0, 0);
	Pose X;
	X.rotation = rotationMatrix(quaternionFromRotationVector(random.direction() * (3 * random.next())));
	X.translation = random.direction() * 2;
	return transformed(mesh, X);
}

struct Body
{
	const char* name;
	Mesh mesh;
};

std::vector<Body> bodies()
{
	return {{"box", placed(makeBoxMesh({0.5, 0.35, 0.25}), 1)}, {"sphere", placed(makeSphereMesh(0.7), 2)},
		{"cylinder", placed(makeCylinderMesh(0.3, 0.5), 3)}, {"cone", placed(makeConeMesh(0.3, 1), 4)},
		{"capsule", placed(makeCapsuleMesh(0.03, 0.5), 5)}, {"torus", placed(makeTorusMesh(0.5, 0.2), 6)},
		{"knot", placed(makeTorusKnotMesh(2, 1, 0.45), 7)}, {"tetrahedron", placed(makeTetrahedronMesh(1), 8)}};
}

Vec3 randomPointOf(const Mesh& mesh, CounterRandom& random)
{
	const auto& t = mesh.triangles[size_t(random.next() * double(mesh.triangles.size()))];
	double a = random.next(), b = random.next();
	if (a + b > 1) a = 1 - a, b = 1 - b;
	const Vec3 p = mesh.vertices[t[0]];
	return p + (mesh.vertices[t[1]] - p) * a + (mesh.vertices[t[2]] - p) * b;
}

bool isCorner(const Mesh& mesh, const Vec3& point)
{
	return std::any_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const Vec3& v) { return distance(v, point) < 1e-6; });
}

/// Expects that each element is a rectangle or triangle whose corners are corners of the mesh, and that there are `elements` of them.
void expectFaces(const Mesh& mesh, const Mesh& corners, size_t elements, int64_t asked)
{
	const ContactSurface surface = surfaceOf(mesh, asked);
	EXPECT_EQ(surface.elements.size(), elements) << asked;
	for (const SurfaceElement& e : surface.elements)
	{
		EXPECT_EQ(e.k11, 0);
		EXPECT_EQ(e.k12, 0);
		EXPECT_EQ(e.k22, 0);
		EXPECT_NEAR(norm(toVec3(e.normal)), 1, 1e-6);
		const Vec3 c = toVec3(e.center), e1 = toVec3(e.e1), e2 = toVec3(e.e2);
		const double area = norm(cross(e1, e2)) * (e.isTriangle ? 0.5 : 4);
		EXPECT_NEAR(area, e.area, 1e-6 * area);
		const std::vector<Vec3> points = e.isTriangle ? std::vector<Vec3>{c, c + e1, c + e2}
													  : std::vector<Vec3>{c - e1 - e2, c + e1 - e2, c + e1 + e2, c - e1 + e2};
		for (const Vec3& p : points) EXPECT_TRUE(isCorner(corners, p));
	}
}

TEST(ContactSurface, AreasAddUpAndNormalsCancel)
{
	for (const Body& body : bodies())
		for (const int64_t elements : {1, 60, 500, 3000})
		{
			SCOPED_TRACE(std::string(body.name) + " " + std::to_string(elements));
			const ContactSurface surface = surfaceOf(body.mesh, elements);
			EXPECT_LT(surface.elements.size(), std::max(size_t(elements), size_t(24)) * 3 / 2 + 60);  // more where a flat face has a hole
			double area = 0;
			Vec3 sum;
			for (const SurfaceElement& e : surface.elements)
			{
				area += e.area;
				sum += toVec3(e.normal) * e.area;
			}
			const double expected = surfaceArea(body.mesh);
			EXPECT_NEAR(area, expected, 1e-6 * expected);
			EXPECT_LT(norm(sum), 1e-6 * expected);
		}
}

TEST(ContactSurface, PolyhedraKeepTheirFaces)
{
	for (const int64_t asked : {1, 24, 500, 5000})
	{
		const Mesh box = makeBoxMesh({0.5, 0.35, 0.25}), turned = placed(box, 1);
		expectFaces(box, box, 6, asked);
		expectFaces(turned, turned, 6, asked);
		const Mesh tetrahedron = placed(makeTetrahedronMesh(1), 2);
		expectFaces(tetrahedron, tetrahedron, 4, asked);
	}
}

TEST(ContactSurface, SmallTrianglesOfAFlatFaceBecomeTheFace)
{
	const Mesh box = placed(makeBoxMesh({0.5, 0.35, 0.25}), 1);
	for (const int64_t asked : {100, 1000}) expectFaces(dividedMesh(box, 0.05), box, 6, asked);
}

TEST(ContactSurface, FacesThatAreNarrowerThanTheOutlinesToleranceKeepTheirArea)
{
	for (const double thickness : {1e-3, 1e-4, 1e-5})
	{
		const Mesh plate = placed(makeBoxMesh({0.5, 0.35, thickness / 2}), 2);
		for (const Mesh& mesh : {plate, dividedMesh(plate, 0.05)})
		{
			const ContactSurface surface = surfaceOf(mesh, 200);
			EXPECT_EQ(surface.validate(), "");
			double area = 0;
			for (const SurfaceElement& e : surface.elements) area += e.area;
			EXPECT_NEAR(area, surfaceArea(plate), 1e-6 * area) << thickness;
			Vec3 sum;
			for (const SurfaceElement& e : surface.elements) sum += double(e.area) * toVec3(e.normal);
			EXPECT_LT(norm(sum), 1e-6) << thickness;
		}
	}
}

/// Block with a bore along z, whose flat faces have triangles from the rim to the outside.
Mesh blockWithBore(double radius, double halfWidth, double halfHeight, int segments)
{
	Mesh mesh;
	for (int i = 0; i < segments; ++i)
	{
		const double angle = 2 * std::numbers::pi * i / segments, c = std::cos(angle), s = std::sin(angle);
		const double outer = halfWidth / std::max(std::fabs(c), std::fabs(s));
		for (const double z : {-halfHeight, halfHeight})
			for (const double r : {radius, outer}) mesh.vertices.push_back({r * c, r * s, z});
	}
	const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
		mesh.triangles.push_back({a, b, c});
		mesh.triangles.push_back({a, c, d});
	};
	for (uint32_t i = 0; i < uint32_t(segments); ++i)
	{
		const uint32_t a = 4 * i, b = 4 * ((i + 1) % uint32_t(segments));
		quad(a, b, b + 1, a + 1);          // lower face, wound below
		quad(a + 2, a + 3, b + 3, b + 2);  // upper face
		quad(a, a + 2, b + 2, b);          // bore
		quad(a + 1, b + 1, b + 3, a + 3);  // outside
	}
	return mesh;
}

TEST(ContactSurface, FlatFacesDoNotReachIntoTheirHoles)
{
	constexpr double kRadius = 0.01;
	for (const int segments : {24, 96, 256})
		for (const int64_t asked : {300, 1000, 3000})
		{
			const ContactSurface surface = surfaceOf(blockWithBore(kRadius, 0.03, 0.02, segments), asked);
			const double inner = kRadius * std::cos(std::numbers::pi / segments);  // of the mesh
			double least = kRadius, area = 0;
			for (const SurfaceElement& e : surface.elements)
			{
				area += e.area;
				if (std::fabs(e.normal[2]) < 0.999) continue;
				const auto points = e.isTriangle ? std::vector<std::pair<int, int>>{{0, 0}, {1, 0}, {0, 1}}
												 : std::vector<std::pair<int, int>>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
				for (size_t i = 0; i < points.size(); ++i)
				{
					const auto [s, t] = points[i];
					const auto [s1, t1] = points[(i + 1) % points.size()];
					const Vec3 a = SheetPoint(e, s, t).position, b = SheetPoint(e, s1, t1).position;
					for (const double share : {0.0, 0.25, 0.5, 0.75})
					{
						const Vec3 p = a + (b - a) * share;
						least = std::min(least, std::hypot(p.x, p.y));
					}
				}
			}
			// The chord of a flat arc may stand for it.
			EXPECT_GT(least, inner - 1.2e-3 * std::sqrt(area / double(asked))) << segments << ' ' << asked;
			EXPECT_NEAR(area, surfaceArea(blockWithBore(kRadius, 0.03, 0.02, segments)), 1e-5 * area);
		}
}

TEST(ContactSurface, LongFacesAreCutAcross)
{
	const ContactSurface surface = surfaceOf(placed(makeBoxMesh({0.05, 0.04, 2}), 3), 500);
	for (const SurfaceElement& e : surface.elements)
	{
		const double a = norm(toVec3(e.e1)), b = norm(toVec3(e.e2));
		EXPECT_LT(std::max(a, b), 6 * std::min(a, b));
	}
	EXPECT_NEAR(volumeOf(surface, {}), 8 * 0.05 * 0.04 * 2, 1e-7);
}

TEST(ContactSurface, SheetsOfASphereHaveItsCurvatureAndNormals)
{
	const double radius = 0.7;
	const Vec3 center{3, -1, 2};
	const ContactSurface surface = surfaceOf(translated(makeSphereMesh(radius, 6), center), 400);
	for (const SurfaceElement& e : surface.elements)
	{
		EXPECT_NEAR(e.k11 / squaredNorm(toVec3(e.e1)), 1 / radius, 0.05 / radius);
		EXPECT_NEAR(e.k22 / squaredNorm(toVec3(e.e2)), 1 / radius, 0.05 / radius);
		EXPECT_NEAR(e.k12 / (norm(toVec3(e.e1)) * norm(toVec3(e.e2))), dot(normalized(toVec3(e.e1)), normalized(toVec3(e.e2))) / radius,
			0.05 / radius);
		EXPECT_GT(dot(normalized(toVec3(e.normal)), normalized(toVec3(e.center) - center)), std::cos(0.01));
	}
}

TEST(ContactSurface, SheetsApproachTheSphereWithThirdOrder)
{
	const Mesh mesh = makeSphereMesh(1, 6);
	const double radius = std::cbrt(massProperties(mesh).volume * 3 / (4 * std::numbers::pi));  // the facets lie within the unit sphere
	double before = 0;
	for (const int64_t elements : {40, 80, 160})
	{
		double sum = 0;
		for (const SurfaceElement& e : surfaceOf(mesh, elements).elements)
			eachGaussPoint(e, [&](const SheetPoint& p, double area) { sum += area * std::pow(norm(p.position) - radius, 2); });
		const double error = std::sqrt(sum / (4 * std::numbers::pi));
		if (before > 0)
		{
			EXPECT_LT(error, before * std::pow(0.5, 1.5)) << elements;
		}
		before = error;
	}
}

TEST(ContactSurface, SheetsOfATorusBendBothWays)
{
	const double ring = 0.5, tube = 0.2;
	const ContactSurface surface = surfaceOf(makeTorusMesh(ring, tube, 288, 144), 1000);
	for (const SurfaceElement& e : surface.elements)
	{
		const Vec3 c = toVec3(e.center);
		const double fromAxis = std::hypot(c.x, c.y), cosine = (fromAxis - ring) / std::hypot(fromAxis - ring, c.z);
		const double around = 1 / tube, along = cosine / (ring + tube * cosine);
		const Vec3 e1 = toVec3(e.e1), e2 = toVec3(e.e2), plane = cross(e1, e2);
		const double square = squaredNorm(plane);  // determinant of the metric
		const double middle = 0.5 * (e.k11 * squaredNorm(e2) - 2 * e.k12 * dot(e1, e2) + e.k22 * squaredNorm(e1)) / square;
		const double half = std::sqrt(middle * middle - (e.k11 * e.k22 - e.k12 * e.k12) / square);
		EXPECT_NEAR(middle + half, around, 0.06 * around);
		EXPECT_NEAR(middle - half, along, 0.06 * around);
	}
}

TEST(ContactSurface, VolumeByTheDivergenceTheoremConverges)
{
	const Body round[] = {{"torus", placed(makeTorusMesh(0.5, 0.2), 1)}, {"knot", placed(makeTorusKnotMesh(2, 1, 0.45), 2)},
		{"ellipsoid", placed(scaled(makeSphereMesh(1, 5), {1, 0.8, 0.4}), 3)}, {"cylinder", placed(makeCylinderMesh(0.3, 0.5, 384), 4)}};
	for (const Body& body : round)
	{
		const MassProperties exact = massProperties(body.mesh);
		for (const int64_t elements : {250, 1000, 4000})
		{
			const double volume = volumeOf(surfaceOf(body.mesh, elements), exact.centerOfMass);
			EXPECT_NEAR(volume, exact.volume, exact.volume * 40 * std::pow(double(elements), -1.5)) << body.name << " " << elements;
		}
	}
}

/// True if a leaf holds the point, and all nodes above it.
bool isHeld(const ContactSurface& surface, uint32_t node, const Vec3& point)
{
	const SurfaceNode& n = surface.nodes[node];
	if (distance(point, toVec3(n.center)) > n.radius) return false;
	return n.isElement() || isHeld(surface, n.child, point) || isHeld(surface, n.child + 1, point);
}

TEST(ContactSurface, BallsHoldTheMeshAndTheSheets)
{
	std::vector<Body> all = bodies();
	all.push_back({"far away", translated(makeTorusMesh(0.5, 0.2), {700, -700, 0})});
	for (const Body& body : all)
	{
		const ContactSurface surface = surfaceOf(body.mesh, 300);
		CounterRandom random(1, 2, 3);
		for (int i = 0; i < 3000; ++i) EXPECT_TRUE(isHeld(surface, 0, randomPointOf(body.mesh, random))) << body.name;
		for (const SurfaceElement& e : surface.elements)
		{
			if (e.isTriangle) continue;
			for (const double s : {-1.0, -0.7, 0.0, 0.4, 1.0})
				for (const double t : {-1.0, -0.2, 0.6, 1.0}) EXPECT_TRUE(isHeld(surface, 0, SheetPoint(e, s, t).position)) << body.name;
		}
	}
}

TEST(ContactSurface, NoElementMixesTheSidesOfAThinPlate)
{
	const ContactSurface plate = surfaceOf(dividedMesh(makeBoxMesh({0.5, 0.4, 0.005}), 0.05), 200);
	for (const SurfaceElement& e : plate.elements) EXPECT_NEAR(norm(toVec3(e.normal)), 1, 1e-6);

	// A lens: its sides meet at a sharp rim.
	const double thickness = 0.02;
	const ContactSurface lens = surfaceOf(scaled(makeSphereMesh(1, 5), {1, 0.8, thickness}), 500);
	for (const SurfaceElement& e : lens.elements)
	{
		const Vec3 c = toVec3(e.center);
		if (c.x * c.x + c.y * c.y / 0.64 > 0.9) continue;
		EXPECT_GT(norm(toVec3(e.normal)), 0.99);
		EXPECT_GT(std::fabs(c.z), 0.2 * thickness);
	}
}

TEST(ContactSurface, NoElementJoinsSheetsThatLieApart)
{
	// Two thick plates above each other, and two domes whose outer sides face the same way.
	const Mesh plate = makeBoxMesh({0.5, 0.4, 0.2}), plates = joined(plate, translated(plate, {0, 0, 0.45}));
	expectFaces(dividedMesh(plates, 0.05), plates, 12, 100);

	const Mesh dome = scaled(makeSphereMesh(1, 5), {1, 1, 0.1});
	for (const SurfaceElement& e : surfaceOf(joined(dome, translated(dome, {0, 0, 0.3})), 600).elements) EXPECT_LT(e.error, 0.03);
}

TEST(ContactSurface, ElementsOfLongTrianglesAreEven)
{
	const Mesh mesh = placed(makeCylinderMesh(0.3, 0.5, 384), 5);
	for (const int64_t elements : {300, 1500, 5000})
	{
		double area = 0, slender = 0;
		for (const SurfaceElement& e : surfaceOf(mesh, elements).elements)
		{
			const double a = norm(toVec3(e.e1)), b = norm(toVec3(e.e2));
			area += e.area;
			if (std::max(a, b) > 3.2 * std::min(a, b)) slender += e.area;
		}
		EXPECT_LT(slender, 0.1 * area) << elements;
	}
}

TEST(ContactSurface, NormalsOfAnElementAgree)
{
	for (const Body& body : bodies())
		for (const SurfaceElement& e : surfaceOf(body.mesh, 1000).elements)
			EXPECT_GT(norm(toVec3(e.normal)), 0.75) << body.name;  // a cap of 120 degrees
}

/// Number of elements over a point whose normal is `normal`, each weighted with its area over that of its shape.
double coverage(const ContactSurface& surface, const Vec3& point, const Vec3& normal)
{
	double sum = 0;
	for (const SurfaceElement& e : surface.elements)
	{
		const Vec3 y = point - toVec3(e.center), e1 = toVec3(e.e1), e2 = toVec3(e.e2), plane = cross(e1, e2);
		if (dot(plane, normal) < 0.5 * norm(plane)) continue;
		const double s = dot(cross(y, e2), plane) / squaredNorm(plane), t = dot(cross(e1, y), plane) / squaredNorm(plane);
		const bool isOver = e.isTriangle ? s >= 0 && t >= 0 && s + t <= 1 : std::fabs(s) <= 1 && std::fabs(t) <= 1;
		if (isOver && std::fabs(dot(y, toVec3(e.normal))) < 0.1) sum += e.area / (norm(plane) * (e.isTriangle ? 0.5 : 4));
	}
	return sum;
}

TEST(ContactSurface, FewElementsGoAroundAThinTube)
{
	// The tube is so long that 500 square elements would be as wide as the tube.
	const Mesh tube = makeTorusKnotMesh(2, 1, 0.08);
	for (const SurfaceElement& e : surfaceOf(tube, 500).elements) EXPECT_GT(norm(toVec3(e.normal)), 0.7);
}

TEST(ContactSurface, ElementsTileTheSurface)
{
	const Mesh mesh = makeSphereMesh(1, 5);
	const ContactSurface surface = surfaceOf(mesh, 2000);
	double shapes = 0, square = 0;
	for (const SurfaceElement& e : surface.elements) shapes += norm(cross(toVec3(e.e1), toVec3(e.e2))) * (e.isTriangle ? 0.5 : 4);
	EXPECT_NEAR(shapes, surfaceArea(mesh), 0.003 * shapes);
	CounterRandom random(4, 5, 6);
	const int points = 4000;
	for (int i = 0; i < points; ++i)
	{
		const Vec3 p = randomPointOf(mesh, random);
		square += std::pow(coverage(surface, p, normalized(p)) - 1, 2) / points;
	}
	EXPECT_LT(std::sqrt(square), 0.2);  // 4 % of the surface covered twice or not at all
}

TEST(ContactSurface, ErrorIsTheDistanceOfTheMeshFromTheSheet)
{
	// A fine sphere lies on the sheet up to the sheet's own error, which a grid of points of the sheet shows too.
	const ContactSurface surface = surfaceOf(makeSphereMesh(1, 6), 60);
	for (const SurfaceElement& e : surface.elements)
	{
		double sum = 0;
		for (int i = 0; i < 100; ++i) sum += std::pow(norm(SheetPoint(e, (i % 10) / 5.0 - 0.9, (i / 10) / 5.0 - 0.9).position) - 1, 2);
		EXPECT_LT(e.error, 2 * std::sqrt(sum / 100) + 1e-4);
		EXPECT_GT(e.error, 0.3 * std::sqrt(sum / 100) - 1e-4);
	}
}

TEST(ContactSurface, SameMeshGivesTheSameBytes)
{
	const Mesh mesh = placed(makeTorusKnotMesh(2, 1, 0.45), 9);
	const ContactSurface a = surfaceOf(mesh, 700), b = surfaceOf(mesh, 700);
	ASSERT_EQ(a.nodes.size(), b.nodes.size());
	ASSERT_EQ(a.elements.size(), b.elements.size());
	EXPECT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(SurfaceNode)), 0);
	EXPECT_EQ(std::memcmp(a.elements.data(), b.elements.data(), a.elements.size() * sizeof(SurfaceElement)), 0);
}

TEST(ContactSurface, BuildCanBeCancelled)
{
	for (const double stopAt : {0.0, 0.3, 0.7})
	{
		ContactSurfaceOptions options;
		options.progress = [&](const char* stage, double fraction) {
			EXPECT_EQ(std::string(stage), "surface");
			return fraction < stopAt;
		};
		const auto result = buildContactSurface(makeSphereMesh(1, 5), options);
		ASSERT_FALSE(result);
		EXPECT_TRUE(result.error().cancelled);
	}
}

TEST(ContactSurface, DegenerateTrianglesAreSkipped)
{
	Mesh mesh = makeSphereMesh(1, 3);
	const ContactSurface clean = surfaceOf(mesh, 200);
	mesh.vertices.push_back(0.5 * (mesh.vertices[0] + mesh.vertices[1]));
	mesh.triangles.push_back({0, 0, 1});
	mesh.triangles.push_back({5, 5, 5});
	mesh.triangles.push_back({0, uint32_t(mesh.vertices.size() - 1), 1});
	const ContactSurface surface = surfaceOf(mesh, 200);
	ASSERT_EQ(surface.elements.size(), clean.elements.size());
	EXPECT_EQ(std::memcmp(surface.elements.data(), clean.elements.data(), clean.elements.size() * sizeof(SurfaceElement)), 0);
}

TEST(ContactSurface, RefusesMeshesWithoutASurface)
{
	Mesh mesh = makeBoxMesh({1, 1, 1});
	EXPECT_FALSE(buildContactSurface(Mesh{}, {}));
	EXPECT_FALSE(buildContactSurface(scaled(mesh, {0, 0, 1}), {}));
	mesh.vertices[2].y = std::numeric_limits<double>::quiet_NaN();
	EXPECT_FALSE(buildContactSurface(mesh, {}));
	mesh.vertices[2].y = std::numeric_limits<double>::infinity();
	EXPECT_FALSE(buildContactSurface(mesh, {}));
}

/// A surface whose nodes and elements can be changed.
struct OpenSurface
{
	std::vector<SurfaceNode> nodes;
	std::vector<SurfaceElement> elements;

	explicit OpenSurface(const ContactSurface& s) : nodes(s.nodes.begin(), s.nodes.end()), elements(s.elements.begin(), s.elements.end()) {}
	std::string fault() const { return ContactSurface{nodes, elements}.validate(); }
};

TEST(ContactSurface, ValidateNamesTheFirstFault)
{
	const ContactSurface surface = surfaceOf(makeCylinderMesh(0.3, 0.5), 200);
	const float nan = std::numeric_limits<float>::quiet_NaN();
	const auto expectFault = [&](const char* words, auto change) {
		OpenSurface broken(surface);
		change(broken);
		EXPECT_NE(broken.fault().find(words), std::string::npos) << words << ": " << broken.fault();
	};
	const size_t triangle = size_t(
		std::find_if(surface.elements.begin(), surface.elements.end(), [](auto& e) { return e.isTriangle; }) - surface.elements.begin());
	ASSERT_LT(triangle, surface.elements.size());
	EXPECT_EQ(ContactSurface{}.validate(), "the surface has no elements");
	expectFault("is not finite", [&](OpenSurface& s) { s.elements[3].e2[1] = nan; });
	expectFault("curvature that is not finite", [&](OpenSurface& s) { s.elements[3].k12 = nan; });
	expectFault("has no area", [&](OpenSurface& s) { s.elements[3].area = 0; });
	expectFault("has an error", [&](OpenSurface& s) { s.elements[3].error = -1; });
	expectFault("normal longer than 1", [&](OpenSurface& s) { s.elements[3].normal[0] = 1.1f; });
	expectFault("neither a triangle", [&](OpenSurface& s) { s.elements[3].isTriangle = 2; });
	expectFault("triangle with a curvature", [&](OpenSurface& s) { s.elements[triangle].k11 = 1; });
	expectFault("is not finite", [&](OpenSurface& s) { s.nodes[2].radius = nan; });
	expectFault("negative radius", [&](OpenSurface& s) { s.nodes[2].radius = -1; });
	expectFault("does not hold its element", [&](OpenSurface& s) {
		for (SurfaceNode& n : s.nodes)
			if (n.isElement()) n.radius *= 0.5f;
	});
	expectFault("number of nodes", [&](OpenSurface& s) { s.nodes.pop_back(); });
	expectFault("do not lie behind it", [&](OpenSurface& s) { s.nodes[0].child = 0; });
	expectFault("do not lie behind it", [&](OpenSurface& s) { s.nodes[0].child = uint32_t(s.nodes.size() - 1); });
	expectFault("has no parent before it", [&](OpenSurface& s) { s.nodes[0].child = 3; });
	expectFault("has two parents", [&](OpenSurface& s) {
		ASSERT_FALSE(s.nodes[1].isElement() || s.nodes[2].isElement());
		s.nodes[2].child = s.nodes[1].child;
	});
	expectFault("element that does not exist", [&](OpenSurface& s) { s.nodes.back().child = SurfaceNode::kElement | 100000; });
	expectFault("belongs to two nodes", [&](OpenSurface& s) {
		for (SurfaceNode& n : s.nodes)
			if (n.isElement()) n.child = SurfaceNode::kElement;
		for (SurfaceNode& n : s.nodes) n.radius = 10;
	});
}
}  // namespace
}  // namespace ist
