// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/ContactFaces.h"

#include "BulletISTCollision/Core/Faces/DepthIntegral.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"
#include "tests/unit/BoredMesh.h"
#include "tests/unit/Core/Query/FaceReference.h"
#include "tests/unit/Core/Query/SurfaceBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace ist;

namespace
{
struct NamedBody
{
	std::string name;
	BodySurface body;
};

const std::vector<NamedBody>& bodies()
{
	static const std::vector<NamedBody> all = {{"torus", surfaceOf(makeTorusMesh(0.2, 0.08), 1500)},
		{"box", surfaceOf(makeBoxMesh({0.2, 0.15, 0.1}), 300)}, {"cone", surfaceOf(makeConeMesh(0.15, 0.3), 800)},
		{"ball", surfaceOf(makeSphereMesh(0.15, 4), 600)}};
	return all;
}

/// Pose of the second of two bodies in the first, both of which lie around `place`.
Pose relativePose(std::mt19937& random, const Vec3& place)
{
	Pose first = randomPose(random, 0.05), second = randomPose(random, 0.2);
	first.translation += place;
	second.translation += place;
	return inverse(first) * second;
}

const kernels::QueryKernel& kernelOf(QueryWorkspace& workspace) { return *workspace.implementation().kernel; }

/// At a plane of the partition rounding decides, and the cells of both sides differ by their errors.
double ofPlanes(const DepthField& field)
{
	double largest = 0;
	for (const DepthCell& cell : field.cells) largest = std::max(largest, double(cell.error));
	return 3 * largest + 1e-6;
}

bool holds(const Box& box, const Vec3& x)
{
	return x.x >= box.lower.x && x.y >= box.lower.y && x.z >= box.lower.z && x.x <= box.upper.x && x.y <= box.upper.y && x.z <= box.upper.z;
}

FaceList listOf(size_t capacity)
{
	FaceList list;
	list.faces = DemandZeroArray<ContactFace>(capacity);
	return list;
}

FaceSums sumsOf(const FaceList& list)
{
	FaceSums sums;
	for (size_t i = 0; i < list.count; ++i)
	{
		const ContactFace& f = list.faces[i];
		sums.area += f.area;
		sums.depth += f.depth;
		sums.areaNormal += f.areaNormal;
		sums.pressure += f.pressure;
		sums.moment += f.depth * f.pressureCenter;
	}
	return sums;
}

TEST(ContactFaces, AgreeWithCutsAtEveryPlane)
{
	QueryWorkspace workspace;
	FaceList list = listOf(20000);
	std::mt19937 random(7);
	for (const Vec3& place : {Vec3{}, Vec3{1000, -400, 300}})
		for (const NamedBody& A : bodies())
			for (const NamedBody& B : bodies())
			{
				double difference = 0, size = 0, area = 0, areaSize = 0, moment = 0, momentSize = 0;
				for (int i = 0; i < 4; ++i)
				{
					const Pose X = relativePose(random, place);
					list.clear();
					collectFaces(B.body, A.body, X, kernelOf(workspace), list);
					ASSERT_EQ(list.dropped, 0U);
					const FaceSums found = sumsOf(list), expected = FaceReference(B.body.surface, A.body.field, X).sums();
					difference += norm(found.pressure - expected.pressure);
					size += expected.depth;
					area += std::fabs(found.area - expected.area) + norm(found.areaNormal - expected.areaNormal);
					areaSize += expected.area;
					moment += norm(found.moment - expected.moment);
					momentSize += 0.2 * expected.depth;
				}
				const std::string names = A.name + " " + B.name;
				EXPECT_GT(size, 0) << names;
				EXPECT_LT(difference, 0.005 * size) << names;
				EXPECT_LT(area, 0.01 * areaSize) << names;
				EXPECT_LT(moment, 0.005 * momentSize) << names;
			}
}

TEST(ContactFaces, AreTheSameInEveryInstructionSet)
{
	FaceList lists[2] = {listOf(20000), listOf(20000)};
	QueryWorkspace portable({1, 1, 64}, InstructionSet::Portable);
	for (const InstructionSet set : kInstructionSets)
	{
		if (!isAvailable(set)) continue;
		QueryWorkspace other({1, 1, 64}, set);
		std::mt19937 random(11);
		for (const NamedBody& A : bodies())
			for (const NamedBody& B : bodies())
			{
				const Pose X = relativePose(random, {});
				for (FaceList& list : lists)
				{
					list.clear();
					collectFaces(B.body, A.body, X, kernelOf(&list == lists ? portable : other), list);
				}
				ASSERT_EQ(lists[0].count, lists[1].count) << toString(set) << ' ' << A.name << ' ' << B.name;
				EXPECT_EQ(lists[0].counts.nodes, lists[1].counts.nodes);
				EXPECT_EQ(lists[0].counts.quarters, lists[1].counts.quarters);
				for (size_t i = 0; i < lists[0].count; ++i)
					ASSERT_EQ(std::memcmp(&lists[0].faces[i], &lists[1].faces[i], sizeof(ContactFace)), 0)
						<< toString(set) << ' ' << A.name << ' ' << B.name << ' ' << i;
			}
	}
}

TEST(ConePoints, HaveTheDepthsOfTheFieldsInEveryInstructionSet)
{
	for (const InstructionSet set : kInstructionSets)
	{
		if (!isAvailable(set)) continue;
		QueryWorkspace workspace({1, 1, 64}, set);
		std::mt19937 random(17);
		ConePoints points(1000);
		for (const NamedBody& A : bodies())
			for (const NamedBody& B : bodies())
			{
				const Pose X_BA = randomPose(random, 0.05);
				points.clear(X_BA);
				std::vector<Vec3> places;
				const int wanted = int(random() % 200);
				// Within the domains of both: the tables answer nowhere else.
				while (int(places.size()) < wanted)
				{
					const Vec3 x = randomPose(random, 0.4).translation;
					if (!holds(A.body.field.domain, x) || !holds(B.body.field.domain, X_BA * x)) continue;
					EXPECT_EQ(points.add(x, 0, 0), places.size());
					places.push_back(x);
				}
				points.sample(A.body, B.body, kernelOf(workspace));
				for (size_t i = 0; i < places.size(); ++i)
				{
					const double inA = std::max(0.0, A.body.field.at(places[i]).depth),
								 inB = std::max(0.0, B.body.field.at(X_BA * places[i]).depth);
					EXPECT_NEAR(points.depthInA(i), inA, ofPlanes(A.body.field)) << toString(set) << ' ' << A.name;
					EXPECT_NEAR(points.depthInB(i), inB, ofPlanes(B.body.field)) << toString(set) << ' ' << B.name;
				}
			}
	}
}

TEST(ContactFaces, AreFiniteAndLieInTheirElements)
{
	QueryWorkspace workspace;
	FaceList list = listOf(20000);
	std::mt19937 random(13);
	// Long triangles of flat faces, some without area in single precision.
	const BodySurface cylinder = surfaceOf(makeCylinderMesh(0.1, 0.4, 300), 400), thin = surfaceOf(makeTorusMesh(0.2, 0.004), 800);
	std::vector<const BodySurface*> pressing = {&cylinder, &thin};
	for (const NamedBody& b : bodies()) pressing.push_back(&b.body);
	for (int i = 0; i < 1000; ++i)
	{
		// Every fourth is a body that nearly lies in itself.
		const bool alike = i % 4 == 3;
		const BodySurface &B = *pressing[size_t(i) % pressing.size()], &A = alike ? B : *pressing[size_t(i) / 7 % pressing.size()];
		Pose X = randomPose(random, alike ? 1e-3 : 0.2);
		if (alike) X.rotation = turned(3e-3, normalized(X.translation));
		list.clear();
		collectFaces(B, A, X, kernelOf(workspace), list);
		for (size_t k = 0; k < list.count; ++k)
		{
			const ContactFace& f = list.faces[k];
			ASSERT_TRUE(isFinite(f.center) && isFinite(f.pressure) && isFinite(f.pressureCenter) && isFinite(f.gradient));
			ASSERT_TRUE(std::isfinite(norm(f.spread.column(0)) + norm(f.spread.column(1)) + norm(f.spread.column(2))));
			ASSERT_GT(f.area, 0);
			ASSERT_GT(f.depth, 0);
			const SurfaceElement& e = B.surface.elements[f.element];
			const double radius = norm(toVec3(e.e1)) + norm(toVec3(e.e2));
			ASSERT_LT(distance(f.center, X * toVec3(e.center)), 1.1 * radius) << i;
			ASSERT_LT(distance(f.pressureCenter, X * toVec3(e.center)), 1.1 * radius) << i;
			ASSERT_LT(norm(f.areaNormal), 2 * f.area) << i;
		}
	}
}

// A face may be a small part of its element, where the kernel has the mean gradient of the depth. The edge of a cube in a pipe is such a
// face. A pipe's depth has the direction of the radius.
TEST(ContactFaces, GradientsAreThoseAtTheFaces)
{
	constexpr double kRadius = 0.2, kHalf = 0.01;
	const BodySurface pipe = surfaceOf(boredMesh(kRadius, {0.25}, 0.1, 256), 1500),
					  cube = surfaceOf(makeBoxMesh({kHalf, kHalf, kHalf}), 300);
	QueryWorkspace workspace;
	FaceList list = listOf(2000);
	std::mt19937 random(23);
	std::uniform_real_distribution<double> u(0, 1);
	double off = 0, area = 0;
	for (int i = 0; i < 200; ++i)
	{
		Pose X;
		X.rotation = turned(2 * std::numbers::pi * u(random), {0, 0, 1});
		const double depth = 1e-4 * (1 + 2 * u(random)), below = std::sqrt(kRadius * kRadius - kHalf * kHalf) - kHalf + depth;
		X.translation = X.rotation * Vec3{0, -below, 0} + Vec3{0, 0, 0.05 * (u(random) - 0.5)};
		list.clear();
		collectFaces(cube, pipe, X, kernelOf(workspace), list);
		for (size_t k = 0; k < list.count; ++k)
		{
			const ContactFace& f = list.faces[k];
			const double angle = norm(normalized(f.gradient) - normalized({f.center.x, f.center.y, 0}));
			EXPECT_LT(angle, 0.05) << i;
			off += f.area * angle;
			area += f.area;
		}
	}
	EXPECT_GT(area, 0);
	// A fifth of the angle between two facets; the bottom of the cube spans four of them.
	EXPECT_LT(off, 0.005 * area);
}

TEST(ContactFaces, AllocateNothing)
{
	QueryWorkspace workspace;
	FaceList list = listOf(20000);
	std::mt19937 random(17);
	Pose poses[20];
	for (Pose& X : poses) X = randomPose(random, 0.2);
	const BodySurface &torus = bodies()[0].body, &box = bodies()[1].body;
	const long before = allocationCount();
	for (const Pose& X : poses)
	{
		collectFaces(torus, box, X, kernelOf(workspace), list);
		collectFaces(box, torus, X, kernelOf(workspace), list);
	}
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(list.count + list.dropped, 100U);
}

TEST(ContactFaces, ThatDoNotFitAreCounted)
{
	QueryWorkspace workspace;
	FaceList list = listOf(20000), few = listOf(16);
	const BodySurface &torus = bodies()[0].body, &box = bodies()[1].body;
	collectFaces(torus, box, {}, kernelOf(workspace), list);
	collectFaces(torus, box, {}, kernelOf(workspace), few);
	ASSERT_GT(list.count, 16U);
	EXPECT_EQ(list.dropped, 0U);
	EXPECT_EQ(few.count + few.dropped, list.count);
}

/// Quads whose four children are quads again, `levels` times; of each level only the first four are opened further, and the others have one
/// element each.
std::vector<SurfaceQuad> deepTree(int levels)
{
	std::vector<SurfaceQuad> quads(1);
	const SurfaceQuad all{{}, {}, {}, {1, 1, 1, 1}, {}}, leaf{{}, {}, {}, {1, -1, -1, -1}, {SurfaceNode::kElement}};
	std::vector<size_t> open = {0};
	for (int level = 0; level < levels; ++level)
	{
		std::vector<size_t> next;
		for (const size_t parent : open)
		{
			quads[parent] = all;
			for (int k = 0; k < 4; ++k)
			{
				quads[parent].child[k] = uint32_t(quads.size());
				next.push_back(quads.size());
				quads.push_back(leaf);
			}
		}
		// The last nodes of a level lie on top of the stack.
		open.assign(next.end() - std::min<std::ptrdiff_t>(4, std::ptrdiff_t(next.size())), next.end());
	}
	return quads;
}

TEST(ContactFaces, NodesThatDoNotFitOnTheStackAreCounted)
{
	QueryWorkspace workspace;
	FaceList list = listOf(20000);
	BodySurface chain = bodies()[3].body;
	for (const int levels : {40, 120})
	{
		chain.tables.quads = deepTree(levels);
		list.clear();
		collectFaces(chain, bodies()[1].body, {}, kernelOf(workspace), list);
		EXPECT_EQ(list.dropped > 0, levels == 120) << levels;
	}
}
}  // namespace
