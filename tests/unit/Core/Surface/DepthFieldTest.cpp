// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/DepthField.h"

#include "BulletISTCollision/Core/Base/CounterRandom.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/BoredMesh.h"
#include "tests/unit/JoinedMesh.h"
#include "tests/unit/NotchedBeam.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
DepthField fieldOf(const MeshDistance& surface, int64_t cells, int threads = 1)
{
	DepthFieldOptions options;
	options.cells = cells;
	options.threads = threads;
	Result<DepthField> field = buildDepthField(surface, options);
	EXPECT_TRUE(field);
	return std::move(field).value();
}

/// Uniform points of a mesh.
std::vector<Vec3> surfacePoints(const Mesh& mesh, size_t count, uint64_t seed)
{
	std::vector<double> areas;
	double sum = 0;
	for (const auto& t : mesh.triangles)
	{
		const Vec3& a = mesh.vertices[t[0]];
		areas.push_back(sum += norm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a)));
	}
	std::vector<Vec3> points;
	for (size_t i = 0; i < count; ++i)
	{
		CounterRandom random(seed, 1, i);
		const size_t k = size_t(std::lower_bound(areas.begin(), areas.end(), random.next() * sum) - areas.begin());
		double u = random.next(), v = random.next();
		if (u + v > 1) u = 1 - u, v = 1 - v;
		const auto& t = mesh.triangles[k];
		const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
		points.push_back(a + (b - a) * u + (c - a) * v);
	}
	return points;
}

/// Uniform points inside the body.
std::vector<Vec3> innerPoints(const MeshDistance& surface, size_t count, uint64_t seed)
{
	const Box box = bounds(surface.mesh());
	std::vector<Vec3> points;
	for (size_t i = 0; points.size() < count; ++i)
	{
		CounterRandom random(seed, 2, i);
		const double x = random.next(), y = random.next(), z = random.next();
		const Vec3 size = box.size(), p = box.lower + Vec3{size.x * x, size.y * y, size.z * z};
		if (surface.contains(p)) points.push_back(p);
	}
	return points;
}

struct Errors
{
	double meanSquareRoot = 0, largest = 0;
};

/// Errors against the exact distance to the mesh.
Errors errorsOf(const DepthField& field, const MeshDistance& surface, const std::vector<Vec3>& points)
{
	Errors e;
	for (const Vec3& p : points)
	{
		const double off = field.at(p).depth + surface.signedDistance(p);
		e.meanSquareRoot += off * off / double(points.size());
		e.largest = std::max(e.largest, std::fabs(off));
	}
	e.meanSquareRoot = std::sqrt(e.meanSquareRoot);
	return e;
}

double errorAtSurface(const MeshDistance& surface, int64_t cells)
{
	return errorsOf(fieldOf(surface, cells), surface, surfacePoints(surface.mesh(), 20000, 5)).meanSquareRoot;
}

/// Number of points where the error is larger than the tolerance.
int pointsOff(const DepthField& field, const MeshDistance& surface, const std::vector<Vec3>& points, double tolerance)
{
	return int(std::count_if(
		points.begin(), points.end(), [&](const Vec3& p) { return std::fabs(field.at(p).depth + surface.signedDistance(p)) > tolerance; }));
}

/// The field must be exact on the surface. Deep inside, a sliver between two creases may hold no sample: then a few points have the depth
/// of a neighbouring face. No contact feels this.
void expectExact(const Mesh& mesh, int64_t cells, size_t most, double tolerance = 1e-6)
{
	const MeshDistance surface(mesh);
	const double size = bounds(mesh).longestSide();
	const DepthField field = fieldOf(surface, cells);
	EXPECT_EQ(field.validate(), "");
	EXPECT_LE(field.cells.size(), most);
	EXPECT_LT(errorsOf(field, surface, surfacePoints(mesh, 20000, 3)).largest, tolerance * size);
	EXPECT_LE(pointsOff(field, surface, innerPoints(surface, 20000, 4), 1e-5 * size), 4) << "of 20000 points";
}

/// No point of the surface may lie in a node that is said to be outside. Points inside are hardly ever deeper than their nodes say.
void expectBounded(const Mesh& mesh, int64_t cells)
{
	const MeshDistance surface(mesh);
	const DepthField field = fieldOf(surface, cells);
	EXPECT_EQ(field.validate(), "");
	std::vector<Vec3> points = surfacePoints(mesh, 100000, 7);
	for (const Vec3& p : innerPoints(surface, 2000, 8)) points.push_back(p);
	size_t outside = 0, deeper = 0;
	for (size_t i = 0; i < points.size(); ++i)
	{
		const double depth = i < 100000 ? 0 : -surface.signedDistance(points[i]);
		bool isDeeper = false;
		const DepthNode* node = field.nodes.data();
		for (;; node = &field.nodes[node->child + (node->beyond(points[i]) > 0 ? 1 : 0)])
		{
			outside += i < 100000 && node->deepest < 0 ? 1 : 0;
			isDeeper = isDeeper || node->deepest < depth;
			if (node->isCell()) break;
		}
		deeper += isDeeper ? 1 : 0;
	}
	EXPECT_EQ(outside, 0u);
	EXPECT_LE(deeper, 4u) << "of 2000 points";
}

/// The field of a box, to be damaged.
struct Parts
{
	std::vector<DepthNode> nodes;
	std::vector<DepthCell> cells;
	Box domain;

	Parts()
	{
		const DepthField field = fieldOf(MeshDistance(makeBoxMesh({0.3, 0.2, 0.1})), 60);
		nodes.assign(field.nodes.begin(), field.nodes.end());
		cells.assign(field.cells.begin(), field.cells.end());
		domain = field.domain;
	}
	std::string fault() const { return DepthField{nodes, cells, domain}.validate(); }
	DepthNode& inner() { return nodes[0]; }
	DepthNode& leaf()
	{
		return *std::find_if(nodes.begin(), nodes.end(), [](const DepthNode& n) { return n.isCell(); });
	}
};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
}  // namespace

TEST(DepthField, OfABoxIsExact)
{
	expectExact(makeBoxMesh({0.5, 0.35, 0.25}), 1500, 400);
	expectExact(makeBoxMesh({0.1, 0.1, 0.1}), 1500, 400);
}

TEST(DepthField, OfATetrahedronIsExact) { expectExact(makeTetrahedronMesh(0.7), 1500, 100); }

TEST(DepthField, OfAThinPlateIsExact) { expectExact(makeBoxMesh({0.5, 0.35, 0.01}), 1500, 200); }

TEST(DepthField, OfTwoShellsIsExactInBoth)
{
	expectExact(joined(makeBoxMesh({0.2, 0.1, 0.1}), translated(makeTetrahedronMesh(0.2), {0.1, 0.3, 0.05})), 2000, 1200,
		5e-5);  // slivers of cells lie where the two fields meet; rounding decides how many: 991 cells on 64-bit ARM
}

TEST(DepthField, ErrorOfASphereFallsWithTheCells)
{
	const double radius = 0.2;
	// The facets of this mesh stand up to 9e-6 m below the sphere. With more cells than here, the field would follow them.
	const MeshDistance surface(makeSphereMesh(radius, 6));
	const double few = errorAtSurface(surface, 50), more = errorAtSurface(surface, 200);
	EXPECT_LT(more, few / 4);
	for (const auto& [cells, error] : {std::pair{50.0, few}, std::pair{200.0, more}})
	{
		const double h2 = 4 * std::numbers::pi * radius * radius / cells;
		EXPECT_LT(error, 0.1 * h2 / (8 * radius)) << cells << " cells";
	}
}

TEST(DepthField, FollowsACylinderAndItsBore)
{
	const double outer = 0.1, inner = 0.06, halfHeight = 0.2;
	const Mesh mesh = boredMesh(inner, {outer}, halfHeight, 256);
	const MeshDistance surface(mesh);
	ASSERT_TRUE(surface.contains({0.08, 0, 0}));
	ASSERT_FALSE(surface.contains({0, 0, 0}));
	const DepthField field = fieldOf(surface, 1500);
	for (const double r : {inner, 0.065, 0.075, 0.085, 0.095, outer})
	{
		const bool isNearMiddle = r > 0.07 && r < 0.09;  // where the depth has a crease
		double squares = 0;
		const size_t count = 5000;
		for (size_t i = 0; i < count; ++i)
		{
			CounterRandom random(9, 1, i);
			const double angle = 2 * std::numbers::pi * random.next(), z = (2 * random.next() - 1) * 0.17;
			const Vec3 outwards{std::cos(angle), std::sin(angle), 0};
			const DepthField::Value value = field.at(outwards * r + Vec3{0, 0, z});
			const double off = value.depth - std::min(outer - r, r - inner);
			squares += off * off / double(count);
			EXPECT_LT(std::fabs(off), 4e-3) << r;
			const double along = dot(value.gradient, outwards) / norm(value.gradient);
			if (isNearMiddle) continue;
			EXPECT_GT(r > 0.08 ? -along : along, 0.9) << r;
		}
		EXPECT_LT(std::sqrt(squares), isNearMiddle ? 6e-4 : 2e-4) << r;
	}
	// In the bore and around the cylinder there is no body.
	for (const double r : {0.0, 0.03, 0.055, 0.106})
		for (double angle = 0; angle < 6; angle += 0.1) EXPECT_LT(field.at({r * std::cos(angle), r * std::sin(angle), 0.1}).depth, 0) << r;
}

// A thin cell of a side wall once reached through the whole notch, with the depth of the top: a beam of the width of the notch was held.
// Cells without samples in the body once had positive depths. The oracle is the distance in closed form.
TEST(DepthField, IsNegativeInTheNotchOfABeam)
{
	for (const auto& [notch, cells] : {std::pair(0.04, 1000), {0.042, 1000}, {0.044, 1100}, {0.048, 1050}, {0.05, 1000}})
	{
		const MeshDistance surface(notchedBeamMesh(notch));
		const DepthField field = fieldOf(surface, cells);
		for (size_t i = 0; i < 200000; ++i)
		{
			CounterRandom random(31, 1, i);
			const double x = (random.next() - 0.5) * notch, y = 0.06 * random.next(), z = 0.04 * random.next() - 0.02;
			const double away = std::min(0.5 * notch - std::fabs(x), y);
			if (away < 2e-4) continue;
			ASSERT_LT(field.at({x, y, z}).depth, 0) << notch << ": " << x << " " << y << " " << z;
		}
	}
}

TEST(DepthField, GradientIsThatOfTheDepth)
{
	const MeshDistance surface(makeTorusMesh(0.5, 0.2, 48, 24));
	const DepthField field = fieldOf(surface, 300);
	size_t compared = 0;
	for (const Vec3& p : innerPoints(surface, 500, 11))
	{
		const DepthField::Value value = field.at(p);
		const double step = 1e-5;
		for (int k = 0; k < 3; ++k)
		{
			Vec3 q = p, r = p;
			q[k] += step, r[k] -= step;
			const DepthField::Value after = field.at(q), before = field.at(r);
			if (after.cell != value.cell || before.cell != value.cell) continue;
			EXPECT_NEAR((after.depth - before.depth) / (2 * step), value.gradient[k], 1e-8);
			++compared;
		}
	}
	EXPECT_GT(compared, 1400u);
}

TEST(DepthField, BoundsHoldOnATorus) { expectBounded(makeTorusMesh(0.5, 0.2), 600); }
TEST(DepthField, BoundsHoldOnAKnot) { expectBounded(makeTorusKnotMesh(2, 1, 0.45), 1000); }
TEST(DepthField, BoundsHoldOnABox) { expectBounded(makeBoxMesh({0.5, 0.35, 0.25}), 500); }
TEST(DepthField, BoundsHoldOnAThinPlate) { expectBounded(makeBoxMesh({0.5, 0.35, 0.005}), 500); }

TEST(DepthField, IsTheSameForAnyNumberOfThreads)
{
	const MeshDistance surface(makeTorusMesh(0.5, 0.2));
	const DepthField one = fieldOf(surface, 800, 1), three = fieldOf(surface, 800, 3);
	ASSERT_EQ(one.nodes.size(), three.nodes.size());
	ASSERT_EQ(one.cells.size(), three.cells.size());
	EXPECT_EQ(std::memcmp(one.nodes.data(), three.nodes.data(), one.nodes.size() * sizeof(DepthNode)), 0);
	EXPECT_EQ(std::memcmp(one.cells.data(), three.cells.data(), one.cells.size() * sizeof(DepthCell)), 0);
}

TEST(DepthField, ReportsProgressAndCanBeCancelled)
{
	const MeshDistance surface(makeTorusMesh(0.5, 0.2));
	int calls = 0;
	double last = 0;
	DepthFieldOptions options;
	options.cells = 300;
	options.progress = [&](const char* stage, double fraction) {
		EXPECT_STREQ(stage, "field");
		EXPECT_GE(fraction, last);
		EXPECT_LE(fraction, 1);
		last = fraction;
		++calls;
		return true;
	};
	EXPECT_TRUE(buildDepthField(surface, options));
	EXPECT_GT(calls, 3);
	for (int stop = 0; stop < calls; stop += 3)
	{
		int left = stop;
		options.progress = [&left](const char*, double) { return left-- > 0; };
		const Result<DepthField> field = buildDepthField(surface, options);
		ASSERT_FALSE(field);
		EXPECT_TRUE(field.error().cancelled);
	}
}

TEST(DepthFieldValidation, AcceptsWhatWasBuilt) { EXPECT_EQ(Parts().fault(), ""); }

TEST(DepthFieldValidation, RefusesAFieldWithoutNodes) { EXPECT_EQ(DepthField().validate(), "there is no node"); }

TEST(DepthFieldValidation, RefusesABadDomain)
{
	Parts parts;
	parts.domain.upper.y = double(kNan);
	EXPECT_EQ(parts.fault(), "the domain is not finite");
	parts.domain.upper.y = parts.domain.lower.y;
	EXPECT_EQ(parts.fault(), "the domain is empty");
}

TEST(DepthFieldValidation, RefusesACellThatIsNotFinite)
{
	float DepthCell::*const values[] = {&DepthCell::depth, &DepthCell::error, &DepthCell::radius};
	for (const auto value : values)
	{
		Parts parts;
		parts.cells[3].*value = kNan;
		EXPECT_EQ(parts.fault(), "cell 3: a value is not finite");
	}
	Parts parts;
	parts.cells[2].center[1] = kNan;
	EXPECT_EQ(parts.fault(), "cell 2: a value is not finite");
	parts.cells[1].gradient[2] = kNan;
	EXPECT_EQ(parts.fault(), "cell 1: a value is not finite");
	parts.cells[0].hessian[5] = kNan;
	EXPECT_EQ(parts.fault(), "cell 0: a value is not finite");
}

TEST(DepthFieldValidation, RefusesANegativeErrorOrRadius)
{
	Parts error, radius;
	error.cells[1].error = -1e-9f;
	EXPECT_EQ(error.fault(), "cell 1: its error or radius is negative");
	radius.cells[1].radius = -1;
	EXPECT_EQ(radius.fault(), "cell 1: its error or radius is negative");
}

TEST(DepthFieldValidation, RefusesABadPlane)
{
	Parts parts;
	parts.inner().normal[0] *= 1.01f;
	parts.inner().normal[1] *= 1.01f;
	parts.inner().normal[2] *= 1.01f;
	EXPECT_EQ(parts.fault(), "node 0: its normal has not unit length");
	parts.inner().offset = kNan;
	EXPECT_EQ(parts.fault(), "node 0: its plane is not finite, or farther away than a body reaches");
}

TEST(DepthFieldValidation, RefusesADepthThatIsNotFiniteOrNotBounded)
{
	Parts parts;
	parts.nodes[parts.inner().child].deepest = parts.inner().deepest + 1;
	EXPECT_EQ(parts.fault(), "node 0: its child has a larger depth");
	parts.inner().deepest = kNan;
	EXPECT_EQ(parts.fault(), "node 0: its largest depth is not finite, or larger than a body");
}

TEST(DepthFieldValidation, RefusesChildrenBeforeTheirParent)
{
	Parts parts;
	parts.inner().child = 0;
	EXPECT_EQ(parts.fault(), "node 0: its children do not come after it");
}

TEST(DepthFieldValidation, RefusesChildrenThatDoNotExist)
{
	Parts parts;
	parts.inner().child = uint32_t(parts.nodes.size()) - 1;
	EXPECT_EQ(parts.fault(), "node 0: its children do not exist");
}

TEST(DepthFieldValidation, RefusesANodeWithTwoParents)
{
	Parts parts;
	size_t second = 1;
	while (parts.nodes[second].isCell()) ++second;
	for (DepthNode& n : parts.nodes) n.deepest = 1;
	parts.inner().child = parts.nodes[second].child;
	EXPECT_NE(parts.fault().find("its child belongs to another node"), std::string::npos) << parts.fault();
}

TEST(DepthFieldValidation, RefusesANodeWithoutParent)
{
	Parts parts;
	parts.nodes.resize(parts.nodes.size() + 1);
	parts.nodes.back().child = uint32_t(parts.cells.size()) | DepthNode::kCell;
	parts.cells.push_back(parts.cells.back());
	EXPECT_NE(parts.fault().find("no node leads to it"), std::string::npos) << parts.fault();
}

TEST(DepthFieldValidation, RefusesACellThatDoesNotExist)
{
	Parts parts;
	parts.leaf().child = uint32_t(parts.cells.size()) | DepthNode::kCell;
	EXPECT_NE(parts.fault().find("its cell does not exist"), std::string::npos) << parts.fault();
}

TEST(DepthFieldValidation, RefusesACellOfTwoNodes)
{
	Parts parts;
	for (const DepthNode& node : parts.nodes)
		if (node.isCell() && !node.isOutside() && node.child != parts.leaf().child) parts.leaf().child = node.child;
	EXPECT_NE(parts.fault().find("its cell belongs to another node"), std::string::npos) << parts.fault();
}

TEST(DepthFieldValidation, RefusesACellWithoutNode)
{
	Parts parts;
	parts.cells.push_back(parts.cells.back());
	EXPECT_NE(parts.fault().find("no node leads to it"), std::string::npos) << parts.fault();
}
}  // namespace ist
