// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Distance/RayCrossings.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "tests/unit/JoinedMesh.h"
#include "tests/unit/SolidAngleWinding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ist
{
namespace
{
class RandomPoints
{
public:
	explicit RandomPoints(const Mesh& mesh) : m_box(bounds(mesh)) {}
	Vec3 next()
	{
		const Vec3 size = m_box.size();
		return m_box.lower + Vec3{size.x * uniform(), size.y * uniform(), size.z * uniform()};
	}

private:
	double uniform() { return std::uniform_real_distribution<double>(-0.05, 1.05)(m_engine); }
	Box m_box;
	std::mt19937 m_engine{7};
};

/// Compares with solid angles. `most`: number of points for which the ray may give no answer.
void expectWinding(const Mesh& mesh, const Vec3& origin, int most)
{
	const RayCrossings crossings(mesh, origin);
	ASSERT_TRUE(crossings.isUsable());
	RandomPoints points(mesh);
	int open = 0;
	for (int i = 0; i < 2000; ++i)
	{
		const Vec3 p = points.next();
		const std::optional<int> found = crossings.windingNumber(p - origin);
		if (!found) ++open;
		ASSERT_NEAR(found.value_or(0), found ? ::windingNumber(mesh, p) : 0, 1e-3) << p.x << ' ' << p.y << ' ' << p.z;
	}
	EXPECT_LE(open, most);
}

TEST(RayCrossings, AreTheSumOfTheSolidAngles)
{
	expectWinding(makeTorusMesh(1, 0.3, 40, 20), {}, 0);
	expectWinding(makeSphereMesh(0.7, 3), {0.1, 0.2, -0.3}, 0);
	expectWinding(makeBoxMesh({1, 2, 3}), {}, 0);
}

TEST(RayCrossings, AreTheSumOfTheSolidAnglesAKilometreFromTheOrigin)
{
	const Vec3 far{700, -600, 400};
	expectWinding(translated(makeTorusMesh(0.1, 0.03, 40, 20), far), far, 0);
	expectWinding(translated(makeTorusMesh(0.1, 0.03, 40, 20), far), {}, 20);
}

TEST(RayCrossings, CountBodiesThatOverlap)
{
	const Mesh torus = makeTorusMesh(1, 0.3, 40, 20);
	const Mesh twice = joined(torus, translated(torus, {0.2, 0.1, 0.05}));
	expectWinding(twice, {}, 0);
	Mesh cavity = makeSphereMesh(0.2, 2);
	for (auto& t : cavity.triangles) std::swap(t[0], t[1]);
	expectWinding(joined(makeSphereMesh(1, 2), cavity), {}, 0);
}

TEST(RayCrossings, HoldForLongThinTriangles)
{
	// Each side of the cylinder is two needles, and its ends are fans of needles.
	expectWinding(makeCylinderMesh(0.001, 1, 2000), {}, 0);
	expectWinding(makeCylinderMesh(1, 0.0005, 2000), {}, 0);
}

TEST(RayCrossings, GiveNoAnswerOnTheSurface)
{
	const RayCrossings crossings(makeBoxMesh({1, 1, 1}), {});
	ASSERT_TRUE(crossings.isUsable());
	for (const Vec3& p : {Vec3{1, 0.25, 0.125}, Vec3{0.3, -1, 0.2}, Vec3{0.3, 0.4, 1}, Vec3{1, 1, 1}, Vec3{-1, -1, 0.5}})
	{
		const int winding = crossings.windingNumber(p).value_or(0);
		EXPECT_TRUE(winding == 0 || winding == 1);
	}
	EXPECT_EQ(crossings.windingNumber({0, 0, 0}), 1);
	EXPECT_EQ(crossings.windingNumber({0, 0, 5}), 0);
}

TEST(RayCrossings, AreNotCountedForOpenMeshes)
{
	Mesh mesh = makeBoxMesh({1, 1, 1});
	mesh.triangles.pop_back();
	EXPECT_FALSE(RayCrossings(mesh, {}).isUsable());
	EXPECT_FALSE(RayCrossings(Mesh{}, {}).isUsable());
	Mesh flipped = makeBoxMesh({1, 1, 1});
	std::swap(flipped.triangles[0][0], flipped.triangles[0][1]);
	EXPECT_FALSE(RayCrossings(flipped, {}).isUsable());
	Mesh infinite = makeBoxMesh({1, 1, 1});
	infinite.vertices[0].x = INFINITY;
	EXPECT_FALSE(RayCrossings(infinite, {}).isUsable());
}
}  // namespace
}  // namespace ist
