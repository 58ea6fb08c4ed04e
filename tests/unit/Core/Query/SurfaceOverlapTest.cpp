// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/SurfaceOverlap.h"

#include "BulletISTCollision/Core/Force/RelativeMotion.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/BoredMesh.h"
#include "tests/unit/Core/Query/SurfaceBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

using namespace ist;

namespace
{
constexpr double kPi = std::numbers::pi;

/// Force on A for a stiffness of 1 Pa/m and equal weights.
Wrench wrenchOf(const OverlapIntegrals& sums) { return 0.5 * (sums.normalB - sums.normalA); }

class SurfaceOverlapTest : public testing::Test
{
protected:
	SurfaceOverlap overlap(const BodySurface& A, const BodySurface& B, const Pose& X) { return surfaceOverlap(A, B, X, m_workspace); }
	SurfaceWorkspace m_workspace;
};

TEST_F(SurfaceOverlapTest, FlatContactIsExactAtEveryDepth)
{
	const BodySurface table = surfaceOf(makeBoxMesh({0.5, 0.5, 0.2}), 300), box = surfaceOf(makeBoxMesh({0.2, 0.2, 0.1}), 300);
	std::mt19937 random(1);
	std::uniform_real_distribution<double> u(-1, 1);
	for (const double depth : {1e-4, 1e-3, 5e-3, 0.02})
		for (int i = 0; i < 8; ++i)
		{
			const Pose X{turned(kPi * u(random), {0, 0, 1}), {0.15 * u(random), 0.15 * u(random), 0.3 - depth}};
			const SurfaceOverlap found = overlap(table, box, X);
			// The box's own normals turn outwards in the wedges at its edges: Int n_B dV over a frustum of 45 degrees.
			const double side = 0.4, inner = side - 2 * depth, frustum = (side * side * side - inner * inner * inner) / 6;
			const double expected = 0.5 * (side * side * depth + frustum);
			EXPECT_NEAR(-wrenchOf(found.total).force.z, expected, 3e-3 * expected) << depth;
			EXPECT_NEAR(found.total.volume, side * side * depth, 3e-3 * side * side * depth) << depth;
			EXPECT_EQ(found.dropped, 0U);
		}
}

// The ends of a cylinder that lies on a plane are inside of it with a sliver each, which faces at the rims of the ends may miss.
TEST_F(SurfaceOverlapTest, ALyingCylinderHasTheForceOfItsSegment)
{
	constexpr double kRadius = 0.05, kLength = 0.1;
	const Mesh pipe = boredMesh(0.045, {kRadius, false}, kLength / 2, 1024);
	const BodySurface slab = surfaceOf(makeBoxMesh({1, 0.1, 1}), 300),
					  lying[] = {surfaceOf(makeCylinderMesh(kRadius, kLength / 2, 1024), 1500), surfaceOf(pipe, 1500)};
	std::mt19937 random(4);
	std::uniform_real_distribution<double> u(-1, 1);
	for (const auto& [depth, tolerance] : {std::pair(1e-5, 0.12), std::pair(3e-5, 0.025), std::pair(1e-4, 0.012)})
	{
		const double h = kRadius - depth,
					 segment = kRadius * kRadius * std::acos(h / kRadius) - h * std::sqrt(depth * (2 * kRadius - depth)),
					 expected = segment * kLength;
		for (int i = 0; i < 60; ++i)
			for (const BodySurface& body : lying)
			{
				const Pose X{
					turned(kPi * u(random), {0, 1, 0}) * turned(kPi * u(random), {0, 0, 1}), {0.8 * u(random), 0.1 + h, 0.8 * u(random)}};
				for (const bool first : {true, false})
				{
					const SurfaceOverlap found = first ? overlap(body, slab, inverse(X)) : overlap(slab, body, X);
					const Wrench wrench = wrenchOf(found.total);
					const Vec3 force = first ? X.rotation * wrench.force : -1 * wrench.force;
					EXPECT_LT(norm(force - expected * Vec3{0, 1, 0}), tolerance * expected) << depth << ' ' << first;
					EXPECT_NEAR(found.total.volume, expected, tolerance * expected) << depth << ' ' << first;
					if (!first) continue;
					EXPECT_LT(norm(wrench.torque), 0.004 * expected) << "its resultant goes through its axis and middle, " << depth;
				}
			}
	}
}

// Two parallel cylinders side by side, of radii r and R, share 4/3 d sqrt(2 d r R / (r + R)) of their length. They have the same slivers,
// and neither is flat. A quarter of the volume was found before missing slivers were looked for.
TEST_F(SurfaceOverlapTest, ParallelCylindersShareTheirLens)
{
	constexpr double kRadius = 0.05, kOther = 0.2, kLength = 0.1, kDepth = 3e-5;
	const BodySurface body = surfaceOf(makeCylinderMesh(kRadius, kLength / 2, 512), 1500),
					  other = surfaceOf(makeCylinderMesh(kOther, 0.2, 512), 1500);
	const double expected = kLength * 4 / 3 * kDepth * std::sqrt(2 * kDepth * kRadius * kOther / (kRadius + kOther));
	std::mt19937 random(1);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int i = 0; i < 60; ++i)
	{
		const Pose X{turned(kPi * u(random), {0, 0, 1}), {kRadius + kOther - kDepth, 0, 0.1 * u(random)}};
		const Pose Y{turned(kPi * u(random), {0, 0, 1}), {0, 0, 0}};
		// The facets of the larger one are 4 um deep, an eighth of the depth.
		EXPECT_NEAR(overlap(other, body, inverse(Y) * X).total.volume, expected, 0.3 * expected);
	}
}

TEST_F(SurfaceOverlapTest, BodiesThatAreApartOrOnlyTouchDoNotPress)
{
	const BodySurface table = surfaceOf(makeBoxMesh({0.5, 0.5, 0.2}), 300), box = surfaceOf(makeBoxMesh({0.2, 0.2, 0.1}), 300);
	const double atOneMillimetre = 1.6e-4;
	for (int i = 0; i < 8; ++i)
	{
		const Mat3 R = turned(0.7 * i, {0, 0, 1});
		EXPECT_LT(norm(wrenchOf(overlap(table, box, {R, {0.02 * i, 0, 0.3}}).total).force), 0.01 * atOneMillimetre);
		EXPECT_EQ(overlap(table, box, {R, {0.02 * i, 0, 0.302}}).total.pairs, 0);
	}
}

TEST_F(SurfaceOverlapTest, BallInAFlatFaceAgreesWithTheClosedForm)
{
	const double R = 0.1;
	const BodySurface table = surfaceOf(makeBoxMesh({0.5, 0.5, 0.2}), 300), ball = surfaceOf(makeSphereMesh(R, 5), 1500);
	for (const double depth : {2e-3, 0.01, 0.04})
	{
		const double c = (R - depth) / R, cap = kPi * depth * depth * (R - depth / 3);
		const double radial = 2 * kPi / 3 * (0.5 * R * R * R * (1 - c * c) - std::pow(R - depth, 3) * (1 / c - 1));
		const SurfaceOverlap found = overlap(table, ball, {turned(1, {0.6, 0.8, 0}), {0.07, 0.11, 0.3 - depth}});
		const double tolerance = depth < 0.005 ? 0.03 : 0.01;
		const double force = 0.5 * (cap + radial);
		EXPECT_NEAR(-wrenchOf(found.total).force.z, force, tolerance * force) << depth;
		EXPECT_NEAR(found.total.volume, cap, 2 * tolerance * cap) << depth;
		EXPECT_EQ(found.patchCount, 1);
	}
}

/// Two rings of radius R and thickness 2 r, one on the other, `depth` deep in each other all around.
struct StackedRings
{
	static constexpr double R = 0.12, r = 0.04;
	static const BodySurface& ring()
	{
		static const BodySurface body = surfaceOf(makeTorusMesh(R, r, 192, 96), 1000);
		return body;
	}
	static Pose at(double depth, double x, double y) { return {turned(0, {0, 0, 1}), {x, y, 2 * r - depth}}; }
	/// The volume in closed form, by Pappus's theorem.
	static double volume(double depth)
	{
		const double half = std::acos(1 - 0.5 * depth / r);
		return 2 * kPi * R * r * r * (2 * half - std::sin(2 * half));
	}
};

// A shallow contact with a large rim. The rim was once found so badly that the volume was a third, and the force with it.
TEST_F(SurfaceOverlapTest, RingsThatTouchAllAroundHaveTheirVolumeAndForce)
{
	std::mt19937 random(12);
	std::uniform_real_distribution<double> u(-1, 1);
	for (const double depth : {5e-4, 1e-3, 2e-3})
		for (int i = 0; i < 5; ++i)
		{
			const SurfaceOverlap found = overlap(
				StackedRings::ring(), StackedRings::ring(), StackedRings::at(depth, 3e-4 * u(random), 3e-4 * u(random)));
			// The facets and the elements leave out some 0.05 mm of the depth.
			const double most = StackedRings::volume(depth), least = StackedRings::volume(depth - 8e-5);
			EXPECT_LT(found.total.volume, 1.02 * most) << depth;
			EXPECT_GT(found.total.volume, 0.98 * least) << depth;
			EXPECT_LT(norm(wrenchOf(found.total).force), 1.02 * most) << depth;
			EXPECT_GT(norm(wrenchOf(found.total).force), 0.98 * least) << depth;
		}
}

// A face that vanished once took its area, and by it 9 % of the force.
TEST_F(SurfaceOverlapTest, RingsThatTiltFeelNoStep)
{
	std::mt19937 random(13);
	std::uniform_real_distribution<double> u(-1, 1);
	for (int path = 0; path < 4; ++path)
	{
		const Vec3 way{4e-3 * u(random), 4e-3 * u(random), 0}, turn{2e-3 * u(random), 2e-3 * u(random), 0.05 * u(random)};
		double last = 0, largest = 0, step = 0;
		for (int i = 0; i <= 1000; ++i)
		{
			Pose X = StackedRings::at(1e-3, 1e-3 * i * way.x, 1e-3 * i * way.y);
			X.rotation = rotationMatrix(quaternionFromRotationVector(1e-3 * i * turn));
			const double force = -wrenchOf(overlap(StackedRings::ring(), StackedRings::ring(), X).total).force.z;
			if (i > 0) step = std::max(step, std::fabs(force - last));
			largest = std::max(largest, last = force);
		}
		EXPECT_LT(step, 0.005 * largest);
	}
}

TEST_F(SurfaceOverlapTest, ContainedBodyHasItsOwnVolumeAndItsOwnFacesOnly)
{
	const BodySurface box = surfaceOf(makeBoxMesh({0.5, 0.5, 0.5}), 300), torus = surfaceOf(makeTorusMesh(0.2, 0.08), 1500);
	const double volume = massProperties(makeTorusMesh(0.2, 0.08)).volume;
	std::mt19937 random(2);
	for (int i = 0; i < 5; ++i)
	{
		const SurfaceOverlap found = overlap(box, torus, randomPose(random, 0.1));
		EXPECT_NEAR(found.total.volume, volume, 2e-3 * volume);
		EXPECT_EQ(found.countA, 0U);
	}
}

TEST_F(SurfaceOverlapTest, IdenticalBodiesInOnePlaceShareTheirVolumeAndDoNotPress)
{
	const Mesh meshes[] = {makeTorusMesh(0.2, 0.08), makeBoxMesh({0.2, 0.1, 0.3})};
	for (const Mesh& mesh : meshes)
	{
		const BodySurface body = surfaceOf(mesh, 1500);
		const double volume = massProperties(mesh).volume;
		const Pose same, moved{turned(0, {0, 0, 1}), {1e-4, 2e-4, -1e-4}}, turnedByADegree{turned(kPi / 180, {0.6, 0, 0.8}), {}};
		for (const Pose& X : {same, moved, turnedByADegree})
		{
			const SurfaceOverlap found = overlap(body, body, X);
			EXPECT_NEAR(found.total.volume, volume, (mesh.triangles.size() > 12 ? 0.08 : 0.02) * volume);
			EXPECT_LT(norm(wrenchOf(found.total).force), 3e-3 * volume);
		}
	}
}

TEST_F(SurfaceOverlapTest, PinIsFreeInItsBoreAndIsPushedBackWhereItTouches)
{
	const double radius = 0.01, clearance = 5e-5;
	constexpr int kSegments = 384;
	const Mesh bore = boredMesh(radius + clearance, {2 * radius}, 0.01, kSegments);
	const BodySurface outer = surfaceOf(bore, 2000), pin = surfaceOf(makeCylinderMesh(radius, 0.02, kSegments), 2000);
	const auto turn = [](int i) { return turned(0.37 * i, {0, 0, 1}); };
	double volume = 0;
	for (int i = 0; i < 5; ++i) volume += overlap(outer, pin, {turn(i), {}}).total.volume / 5;
	EXPECT_LT(volume, 1e-10);  // 0.1 mm^3
	for (int i = 0; i < 5; ++i)
	{
		// Length 20 mm; a pin that is off by e is e cos(phi) - clearance deep at the angle phi.
		const double push = 1e-4, off = clearance + push;
		double expected = 0;
		constexpr int kSteps = 2000;
		for (int k = 0; k < kSteps; ++k)
		{
			const double phi = (k + 0.5) / kSteps * kPi / 2, depth = off * std::cos(phi) - clearance;
			expected += std::max(0.0, depth) * std::cos(phi) * 2 * radius * 0.02 * kPi / 2 / kSteps;
		}
		const Vec3 along{std::cos(0.9 * i), std::sin(0.9 * i), 0};
		const Vec3 force = wrenchOf(overlap(outer, pin, {turn(i), off * along}).total).force;
		EXPECT_NEAR(dot(force, along), expected, 0.03 * expected);
		EXPECT_LT(norm(force - dot(force, along) * along), 0.026 * expected);  // 1.5 degrees
	}
}

TEST_F(SurfaceOverlapTest, StiffnessIsTheDerivativeOfTheForce)
{
	const BodySurface A = surfaceOf(makeTorusMesh(0.2, 0.08), 2000), B = surfaceOf(makeBoxMesh({0.1, 0.2, 0.1}), 300);
	std::mt19937 random(3);
	for (int i = 0; i < 6; ++i)
	{
		const Pose X = randomPose(random, 0.15);
		const SurfaceOverlap found = overlap(A, B, X);
		if (found.total.volume < 1e-5) continue;
		double difference = 0, size = 0;
		const double h = 1e-5;
		const OverlapIntegrals total = found.total;
		for (int axis = 0; axis < 3; ++axis)
		{
			Pose ahead = X, behind = X;
			ahead.translation[axis] += h;
			behind.translation[axis] -= h;
			const Vec3 slope = (wrenchOf(overlap(A, B, ahead).total).force - wrenchOf(overlap(A, B, behind).total).force) / (2 * h);
			for (int other = 0; other < 3; ++other)
			{
				const double k = 0.5 * (total.stiffnessA(axis, other) + total.stiffnessB(axis, other));
				difference += (slope[other] - k) * (slope[other] - k);
				size += slope[other] * slope[other];
			}
		}
		EXPECT_LT(difference, 0.05 * 0.05 * size) << i;
	}
}

TEST_F(SurfaceOverlapTest, TiltStiffnessIsTheDerivativeOfTheTorque)
{
	const BodySurface torus = surfaceOf(makeTorusMesh(0.2, 0.08), 2000), table = surfaceOf(makeBoxMesh({0.5, 0.5, 0.2}), 300),
					  box = surfaceOf(makeBoxMesh({0.2, 0.1, 0.1}), 300);
	struct Case
	{
		const BodySurface &A, &B;
		Pose X;
		double tolerance;
	};
	// The faces of boxes are few and large: one face has the whole stiffness.
	const Case cases[] = {{table, box, {turned(0.4, {0, 0, 1}), {0.03, 0.05, 0.295}}, 0.01},
		{box, table, {turned(0.4, {0, 0, 1}), {0.03, 0.05, -0.295}}, 0.01}, {box, box, {turned(1.6, {0, 0, 1}), {0.02, 0.01, 0.19}}, 0.03},
		{torus, box, {turned(0.3, {1, 0, 0}), {0.15, 0, 0.15}}, 0.05}, {table, torus, {turned(0.02, {1, 0, 0}), {0, 0, 0.27}}, 0.05}};
	for (const Case& c : cases)
	{
		const SurfaceOverlap found = overlap(c.A, c.B, c.X);
		const OverlapIntegrals total = found.total;
		ASSERT_GT(total.volume, 0);
		double difference = 0, size = 0;
		constexpr double kAngle = 1e-5;
		for (int axis = 0; axis < 3; ++axis)
		{
			// Turning A by an angle turns B back, about A's origin.
			Vec3 unit;
			unit[axis] = 1;
			const auto torque = [&](double angle) {
				const Pose X{turned(-angle, unit) * c.X.rotation, turned(-angle, unit) * c.X.translation};
				const Wrench w = wrenchOf(overlap(c.A, c.B, X).total);
				return turned(angle, unit) * w.torque;
			};
			// About the torque's own axis: besides, the torque turns with A.
			const double slope = (torque(kAngle) - torque(-kAngle))[axis] / (2 * kAngle);
			// On flat bodies the force moves on, or turns, which is no stiffness (moveB).
			const auto foretold = [&](double angle) {
				OverlapIntegrals moved = total;
				moveB(moved, {{}, -angle * unit});
				return turned(angle, unit) * wrenchOf(moved).torque;
			};
			const double k = (foretold(kAngle) - foretold(-kAngle))[axis] / (2 * kAngle);
			difference += (slope - k) * (slope - k);
			size += slope * slope;
		}
		EXPECT_LT(std::sqrt(difference), c.tolerance * std::sqrt(size)) << &c - cases;
	}
}

TEST_F(SurfaceOverlapTest, DepthOfFlatContactAgreesWithTheClosedForm)
{
	const BodySurface table = surfaceOf(makeBoxMesh({0.5, 0.5, 0.2}), 300), box = surfaceOf(makeBoxMesh({0.2, 0.2, 0.1}), 300);
	for (const double h : {1e-3, 5e-3, 0.02})
	{
		const SurfaceOverlap found = overlap(table, box, {turned(0.4, {0, 0, 1}), {0.03, 0.05, 0.3 - h}});
		const double side = 0.4, ofTable = side * side * h * h / 2;
		// The part of the box that is deeper than t has the section (side - 2 t)^2.
		const double ofBox = side * side * h * h / 2 - 2 * side * h * h * h / 3 + h * h * h * h / 3;
		EXPECT_NEAR(found.total.depthA, ofTable, 0.01 * ofTable) << h;
		// Few faces make few cones, and these see little of the creases at the box's edges.
		EXPECT_NEAR(found.total.depthB, ofBox, (h < 0.01 ? 0.05 : 0.12) * ofBox) << h;
	}
}

TEST_F(SurfaceOverlapTest, DepthAgreesWithQuadrature)
{
	const Mesh meshes[] = {makeTorusMesh(0.2, 0.08), makeBoxMesh({0.1, 0.2, 0.1}), makeSphereMesh(0.15, 4)};
	std::mt19937 random(6);
	std::uniform_real_distribution<double> u(0, 1);
	double squares = 0;
	int compared = 0;
	for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {1, 1}, {1, 2}})
	{
		const MeshDistance ofA(meshes[a]), ofB(meshes[b]);
		const BodySurface A = surfaceOf(meshes[a], 1000), B = surfaceOf(meshes[b], 1000);
		const Box box = bounds(meshes[b]);
		for (int i = 0; i < 6; ++i)
		{
			const Pose X = randomPose(random, 0.15);
			const OverlapIntegrals found = overlap(A, B, X).total;
			double depthA = 0, depthB = 0;
			int hits = 0;
			for (int k = 0; k < 20000; ++k)
			{
				const Vec3 p = box.lower + Vec3{u(random) * box.size().x, u(random) * box.size().y, u(random) * box.size().z};
				const double inB = -ofB.signedDistance(p), inA = inB > 0 ? -ofA.signedDistance(X * p) : 0;
				if (!(inA > 0)) continue;
				++hits;
				depthA += inA;
				depthB += inB;
			}
			if (hits < 1500) continue;
			// The points have a standard error of 2 %.
			for (const double off : {found.depthA * hits / (found.volume * depthA) - 1, found.depthB * hits / (found.volume * depthB) - 1})
			{
				// An overlap that goes around the hole of a torus is the worst case: cones leave it and come back.
				EXPECT_LT(std::fabs(off), 0.25) << a << b << i;
				squares += off * off;
				++compared;
			}
		}
	}
	ASSERT_GT(compared, 20);
	EXPECT_LT(std::sqrt(squares / compared), 0.08);
}

TEST_F(SurfaceOverlapTest, ForceIsTheGradientOfTheEnergy)
{
	const BodySurface A = surfaceOf(makeTorusMesh(0.2, 0.08), 2000), B = surfaceOf(makeBoxMesh({0.1, 0.2, 0.1}), 300);
	const auto energy = [](const OverlapIntegrals& total) { return 0.5 * (total.depthA + total.depthB); };
	std::mt19937 random(3);
	double squares = 0;
	int compared = 0;
	for (int i = 0; i < 6; ++i)
	{
		const Pose X = randomPose(random, 0.15);
		const OverlapIntegrals found = overlap(A, B, X).total;
		if (found.volume < 1e-5) continue;
		EXPECT_GT(energy(found), 0);
		const double h = 1e-3;
		Vec3 slope;
		for (int axis = 0; axis < 3; ++axis)
		{
			Pose ahead = X, behind = X;
			ahead.translation[axis] += h;
			behind.translation[axis] -= h;
			slope[axis] = (energy(overlap(A, B, ahead).total) - energy(overlap(A, B, behind).total)) / (2 * h);
		}
		// B pushes A by what the energy grows when B moves.
		const Vec3 force = wrenchOf(found).force;
		squares += squaredNorm(slope - force) / squaredNorm(std::max(norm(force), 0.25 * found.volume) * Vec3{1, 0, 0});
		++compared;
	}
	ASSERT_GT(compared, 3);
	EXPECT_LT(std::sqrt(squares / compared), 0.2);
}

TEST_F(SurfaceOverlapTest, SwappedBodiesAndAMovedFrameChangeNothing)
{
	const BodySurface A = surfaceOf(makeTorusMesh(0.2, 0.08), 800), B = surfaceOf(makeConeMesh(0.15, 0.3), 800);
	std::mt19937 random(4);
	for (int i = 0; i < 10; ++i)
	{
		const Pose X = randomPose(random, 0.15);
		const OverlapIntegrals ofA = overlap(A, B, X).total, ofB = overlap(B, A, inverse(X)).total;
		EXPECT_NEAR(ofA.volume, ofB.volume, 1e-4 * ofA.volume + 1e-12);
		const Vec3 force = wrenchOf(ofA).force, opposite = X.rotation * wrenchOf(ofB).force;
		EXPECT_LT(norm(force + opposite), 1e-4 * norm(force) + 1e-12);
	}
}

TEST_F(SurfaceOverlapTest, PatchesAddUpAndPartsHaveTheirOwnVolumes)
{
	// A slab lies on two feet of different depth.
	Mesh feet = transformed(makeBoxMesh({0.05, 0.05, 0.1}), {turned(0, {0, 0, 1}), {-0.3, 0, 0}});
	const Mesh other = transformed(makeBoxMesh({0.05, 0.05, 0.11}), {turned(0, {0, 0, 1}), {0.3, 0, 0}});
	const uint32_t base = uint32_t(feet.vertices.size());
	feet.vertices.insert(feet.vertices.end(), other.vertices.begin(), other.vertices.end());
	for (auto t : other.triangles) feet.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
	const BodySurface A = surfaceOf(feet, 300), B = surfaceOf(makeBoxMesh({0.5, 0.2, 0.1}), 300);
	const SurfaceOverlap found = overlap(A, B, {turned(0, {0, 0, 1}), {0, 0, 0.19}});
	// Each foot presses with its top and, where the slab's depth turns sideways, a little with its sides.
	double volume = 0, ofFoot[2] = {};
	Vec3 force;
	for (int p = 0; p < found.patchCount; ++p)
	{
		const OverlapIntegrals& patch = found.patches[p];
		EXPECT_NEAR(std::fabs(patch.firstMoment.x / patch.volume), 0.3, 0.05);
		ofFoot[patch.firstMoment.x > 0] += patch.volume;
		volume += patch.volume;
		force += wrenchOf(patch).force;
	}
	EXPECT_NEAR(ofFoot[0], 1e-4, 2e-6);
	EXPECT_NEAR(ofFoot[1], 2e-4, 4e-6);
	EXPECT_NEAR(volume, found.total.volume, 1e-12);
	EXPECT_LT(norm(force - wrenchOf(found.total).force), 1e-12);
}

TEST_F(SurfaceOverlapTest, FacesThatDoNotFitAreCounted)
{
	const BodySurface A = surfaceOf(makeTorusMesh(0.2, 0.08), 800);
	SurfaceWorkspace small(16);
	const Pose X{turned(0.3, {0, 1, 0}), {0.05, 0.02, 0.01}};
	const SurfaceOverlap all = overlap(A, A, X);
	ASSERT_GT(all.countA + all.countB, 32U);
	const size_t count = all.countA + all.countB;
	const SurfaceOverlap few = surfaceOverlap(A, A, X, small);
	EXPECT_EQ(few.countA + few.countB + few.dropped, count);
}

TEST_F(SurfaceOverlapTest, ALimitOfFacesEndsTheSearch)
{
	const BodySurface torus = surfaceOf(makeTorusMesh(0.5, 0.2), 1000);
	const Pose X{turned(0.3, {0, 1, 0}), {0.05, 0.02, 0.01}};
	const SurfaceOverlap whole = surfaceOverlap(torus, torus, X, m_workspace);
	const int64_t faces = int64_t(whole.countA + whole.countB);
	ASSERT_GT(faces, 500);
	const SurfaceOverlap just = surfaceOverlap(torus, torus, X, m_workspace, {}, 8, faces);
	EXPECT_FALSE(just.isOverLimit);
	EXPECT_EQ(just.total.volume, whole.total.volume);
	// The last face may be of A or of B.
	for (const int64_t most : {faces - 1, int64_t(whole.countB) - 1, int64_t(50), int64_t(0)})
	{
		const SurfaceOverlap over = surfaceOverlap(torus, torus, X, m_workspace, {}, 8, most);
		EXPECT_TRUE(over.isOverLimit) << most;
		EXPECT_EQ(over.total.pairs, 0) << most;
		EXPECT_EQ(over.countA + over.countB, 0U) << most;
		EXPECT_LT(over.counts.elements, most > 50 ? whole.counts.elements + 1 : whole.counts.elements / 3) << most;
	}
}

TEST_F(SurfaceOverlapTest, AllocatesNothing)
{
	const BodySurface A = surfaceOf(makeTorusMesh(0.2, 0.08), 800), B = surfaceOf(makeBoxMesh({0.1, 0.2, 0.1}), 300);
	std::mt19937 random(5);
	Pose poses[20];
	for (Pose& X : poses) X = randomPose(random, 0.2);
	const long before = allocationCount();
	int64_t faces = 0;
	for (const Pose& X : poses) faces += overlap(A, B, X).total.pairs;
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(faces, 100);
}
}  // namespace
