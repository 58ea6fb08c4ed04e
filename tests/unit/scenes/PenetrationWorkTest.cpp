// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/PenetrationWork.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>

using namespace ist;
using namespace scenes;

namespace
{
InnerSphereTree built(const Mesh& mesh, int64_t spheres)
{
	BuildOptions options;
	options.maxSpheres = spheres;
	Result<InnerSphereTree> tree = buildTree(mesh, options);
	EXPECT_TRUE(tree);
	return std::move(tree).value();
}

const InnerSphereTree& coarseBox()
{
	static const InnerSphereTree tree = built(makeBoxMesh({0.5, 0.5, 0.5}), 100);
	return tree;
}
}  // namespace

// Face on through a wide plate whose field has all the weight: the force on a face a grows as k a s up to the middle of the thickness t,
// and falls to zero where the face comes out. Peak k a t / 2, work k a t^2 / 4 at s = t.
TEST(PenetrationWork, OfABoxThroughAPlateIsThatOfTheClosedForm)
{
	const double edge = 0.3, t = 0.1, k = 2e4;
	const InnerSphereTree plate = built(makeBoxMesh({0.3, t / 2, 0.35}), 5000),
						  box = built(makeBoxMesh({edge / 2, edge / 2, edge / 2}), 3000);
	QueryWorkspace workspace;
	const double start = edge / 2 + t / 2 + 0.05;
	Pose X_PB;
	X_PB.translation = {0.05, start, -0.03};
	for (const bool boxMoves : {true, false})
	{
		const Result<PenetrationWork> found = boxMoves ? penetrationWork(box, plate, inverse(X_PB), {0, -2, 0}, 0.3, {k, 0, 1}, workspace)
													   : penetrationWork(plate, box, X_PB, {0, 1, 0}, 0.3, {k, 1, 0}, workspace);
		ASSERT_TRUE(found);
		const PenetrationWork& b = found.value();
		const double area = edge * edge;
		std::printf("  force %+.2f %%, energy %+.2f %%, at %.4f m\n", 100 * (b.force / (k * area * t / 2) - 1),
			100 * (b.energy / (k * area * t * t / 4) - 1), b.forceAt - 0.05);
		EXPECT_NEAR(b.force, k * area * t / 2, 0.05 * k * area * t / 2);
		EXPECT_NEAR(b.energy, k * area * t * t / 4, 0.05 * k * area * t * t / 4);
		EXPECT_NEAR(b.forceAt, 0.05 + t / 2, 0.1 * t);
	}
}

TEST(PenetrationWork, IsNothingWhereTheWayMeetsNothing)
{
	const InnerSphereTree& box = coarseBox();
	QueryWorkspace workspace;
	Pose apart;
	apart.translation = {3, 0, 0};
	const Result<PenetrationWork> found = penetrationWork(box, box, apart, {-1, 0, 0}, 5, {1, 0.5, 0.5}, workspace);
	ASSERT_TRUE(found);
	EXPECT_EQ(found.value().force, 0);
	EXPECT_EQ(found.value().energy, 0);
}

TEST(PenetrationWork, RefusesWhatIsNoWay)
{
	const InnerSphereTree& box = coarseBox();
	QueryWorkspace workspace;
	const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
	const auto asked = [&](const Vec3& direction, double way, double k, int steps) {
		return bool(penetrationWork(box, box, {}, direction, way, {k, 0.5, 0.5}, workspace, steps));
	};
	EXPECT_TRUE(asked({1, 0, 0}, 1, 1, 3));
	EXPECT_FALSE(asked({0, 0, 0}, 1, 1, 3));
	EXPECT_FALSE(asked({nan, 0, 0}, 1, 1, 3));
	EXPECT_FALSE(asked({1, 0, 0}, 0, 1, 3));
	EXPECT_FALSE(asked({1, 0, 0}, infinity, 1, 3));
	EXPECT_FALSE(asked({1, 0, 0}, 1, nan, 3));
	EXPECT_FALSE(asked({1, 0, 0}, 1, -1, 3));
	EXPECT_FALSE(asked({1, 0, 0}, 1, 1, 0));
	Pose bent;
	bent.rotation.m[0][0] = 2;
	EXPECT_FALSE(penetrationWork(box, box, bent, {1, 0, 0}, 1, {}, workspace));
}
