// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/Core/Mesh/RandomShapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

using namespace ist;

namespace
{
std::vector<MomentEllipsoid> cloud(int count, unsigned seed, float far)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<float> u(-1, 1);
	std::vector<MomentEllipsoid> balls(static_cast<size_t>(count));
	for (MomentEllipsoid& b : balls)
	{
		b.x = far + u(random);
		b.y = u(random);
		b.z = u(random);
		b.R = 0.05f + 0.02f * u(random);
		b.density = 0.8f + 0.1f * u(random);
		b.nx = u(random);
		b.ny = u(random);
		b.nz = u(random);
		b.depth = 0.1f + 0.05f * u(random);
		giveRandomShape(b, random);
	}
	return balls;
}

struct Moments
{
	double mass = 0, depth = 0;
	SymmetricMatrix3 second;
	Vec3 first, normal;
};

/// Second moment Int r r^T dm about the origin. For an ellipsoid about its centre it is m P / 5.
Moments momentsOf(const std::vector<MomentEllipsoid>& balls)
{
	Moments sum;
	for (const MomentEllipsoid& b : balls)
	{
		const double m = b.density * ballVolume(b.R);
		sum.mass += m;
		sum.first += b.center() * m;
		sum.second += (SymmetricMatrix3::square(b.center()) + b.shape() * 0.2) * m;
		sum.normal += b.normal() * m;
		sum.depth += m * b.depth;
	}
	return sum;
}

std::vector<MomentEllipsoid> real(const BallTree& tree)
{
	std::vector<MomentEllipsoid> balls;
	for (const MomentEllipsoid& b : tree.slots())
		if (b.density > 0) balls.push_back(b);
	return balls;
}
}  // namespace

TEST(TreeLevels, EveryLevelKeepsTheMomentsAndIsAValidTree)
{
	for (const float far : {0.0f, 3.0f})
	{
		const BallTree leaves = buildBallTree(cloud(5000, 3, far));
		const Moments expected = momentsOf(real(leaves));
		const std::vector<BallTree> levels = buildLevels(leaves);
		ASSERT_GE(levels.size(), 4u);
		size_t above = leaves.ballCount();
		for (const BallTree& level : levels)
		{
			EXPECT_EQ(level.validate(), "");
			EXPECT_EQ(level.ballCount(), above / 3);
			above = level.ballCount();
			const Moments m = momentsOf(real(level));
			EXPECT_NEAR(m.mass, expected.mass, 1e-6 * expected.mass);
			const double size = expected.second.trace();
			const SymmetricMatrix3 off = m.second + expected.second * -1;
			for (double v : {off.xx, off.yy, off.zz, off.xy, off.xz, off.yz}) EXPECT_NEAR(v, 0, 1e-5 * size);
			EXPECT_NEAR(m.depth, expected.depth, 1e-6 * expected.mass);
			EXPECT_LT(norm(m.first - expected.first), 1e-6 * expected.mass * (1 + far));
			EXPECT_LT(norm(m.normal - expected.normal), StoredEllipsoid::kStep * expected.mass);  // half a step in each component
		}
	}
}

TEST(TreeLevels, SidesOfAPlateAreNotMerged)
{
	// There are two sheets of balls; the sheets are closer to each other than the balls of one sheet are.
	std::vector<MomentEllipsoid> balls;
	for (int i = 0; i < 24; ++i)
		for (int j = 0; j < 24; ++j)
			for (const float side : {-1.0f, 1.0f})
			{
				MomentEllipsoid b;
				b.x = 0.1f * float(i);
				b.y = 0.1f * float(j);
				b.z = 0.02f * side;
				b.R = 0.02f;
				b.density = 1;
				b.nz = side;
				makeRound(b);
				balls.push_back(b);
			}
	const std::vector<BallTree> levels = buildLevels(buildBallTree(balls));
	ASSERT_FALSE(levels.empty());
	int mixed = 0;
	for (const MomentEllipsoid& b : real(levels[0])) mixed += std::fabs(b.nz) < 0.999;
	EXPECT_EQ(mixed, 0);
}

namespace
{
SymmetricMatrix3 gradientOf(const std::vector<MomentEllipsoid>& pieces)
{
	std::vector<uint32_t> all(pieces.size());
	std::iota(all.begin(), all.end(), 0u);
	return normalGradient(merged(pieces.data(), all.data(), all.size()), pieces.data(), all.data(), all.size());
}
}  // namespace

// The normals are n = G x, for the points of a ball and of a layer. The pieces are so small that each has one normal.
TEST(TreeLevels, GradientOfALinearFieldIsItsSlope)
{
	std::mt19937 random(5);
	std::uniform_real_distribution<float> u(-1, 1);
	const SymmetricMatrix3 G{0.4, -0.3, 0.2, 0.1, 0.25, -0.15};
	std::vector<MomentEllipsoid> pieces(40);
	for (const double thickness : {1.0, 0.1})
	{
		for (MomentEllipsoid& p : pieces)
		{
			p = {};
			p.setPlace(Vec3{5 + u(random), u(random), thickness * u(random)});
			p.R = 1e-3f * (1.5f + u(random));
			p.density = 1;
			makeRound(p);
			p.setNormal(G * p.center());
		}
		const SymmetricMatrix3 off = gradientOf(pieces) + G * -1;
		for (double v : {off.xx, off.yy, off.zz, off.xy, off.xz, off.yz}) EXPECT_NEAR(v, 0, 1e-5 / thickness);
	}
	EXPECT_EQ(gradientOf({pieces[3]}).trace(), 0) << "one piece has one normal";
}

// The normals are random in a layer. A step of any component of the slope increases the sum of squares as much as the opposite step
// does.
TEST(TreeLevels, GradientIsTheBestOfAllSymmetricOnes)
{
	std::mt19937 random(6);
	std::normal_distribution<double> gauss;
	std::vector<MomentEllipsoid> pieces(30);
	std::vector<uint32_t> all(pieces.size());
	std::iota(all.begin(), all.end(), 0u);
	for (MomentEllipsoid& p : pieces)
	{
		p.setPlace({gauss(random), gauss(random), 0.2 * gauss(random)});
		p.R = 1e-3f;
		p.density = 1;
		makeRound(p);
		p.setNormal(Vec3{gauss(random), gauss(random), gauss(random)} * 0.3);
	}
	const MomentEllipsoid whole = merged(pieces.data(), all.data(), all.size());
	const SymmetricMatrix3 G = gradientOf(pieces);
	const auto squares = [&](const SymmetricMatrix3& slopes) {
		double sum = 0;
		for (const MomentEllipsoid& p : pieces) sum += squaredNorm(p.normal() - whole.normal() - slopes * (p.center() - whole.center()));
		return sum;
	};
	const double least = squares(G), step = 0.1;
	for (double SymmetricMatrix3::*entry : {&SymmetricMatrix3::xx, &SymmetricMatrix3::yy, &SymmetricMatrix3::zz, &SymmetricMatrix3::xy,
			 &SymmetricMatrix3::xz, &SymmetricMatrix3::yz})
	{
		SymmetricMatrix3 more = G, less = G;
		more.*entry += step;
		less.*entry -= step;
		const double curvature = squares(more) + squares(less) - 2 * least;
		ASSERT_GT(curvature, 0);
		EXPECT_LT(std::fabs(squares(more) - squares(less)), 1e-3 * curvature) << "a minimum: a parabola with its vertex at G";
	}
}

// Two balls of radius r lie at x = -a and a and have normals -1 and 1. The best slope is Int n x over Int x^2: a / (a^2 + r^2 / 5).
TEST(TreeLevels, GradientCountsThePiecesOwnSize)
{
	std::vector<MomentEllipsoid> pieces(2);
	for (const float side : {-1.0f, 1.0f})
	{
		MomentEllipsoid& p = pieces[side > 0];
		p.x = 0.3f * side;
		p.R = 0.25f;
		p.density = 1;
		p.nx = side;
		makeRound(p);
	}
	const SymmetricMatrix3 G = gradientOf(pieces);
	EXPECT_NEAR(G.xx, 0.3 / (0.09 + 0.0625 / 5), 1e-5);
	for (double v : {G.yy, G.zz, G.xy, G.xz, G.yz}) EXPECT_NEAR(v, 0, 1e-6);
}

// The leaves are those of small cubes, with the normals of the ball. With mean normals alone coarse levels press too little, and
// coarser levels even less.
TEST(TreeLevels, PressAsMuchAsTheLeaves)
{
	constexpr double kSide = 0.1;
	std::vector<MomentEllipsoid> cubes;
	for (double x = -0.95; x < 1; x += kSide)
		for (double y = -0.95; y < 1; y += kSide)
			for (double z = -0.95; z < 1; z += kSide)
			{
				const Vec3 c{x, y, z};
				if (!(norm(c) < 1)) continue;
				MomentEllipsoid cube = momentEllipsoid(c, SymmetricMatrix3::identity(kSide * kSide * 5 / 12), kSide * kSide * kSide);
				cube.setNormal(c / norm(c));
				cube.depth = float(1 - norm(c));
				cubes.push_back(cube);
			}
	InnerSphereTree body, without;
	body.law = without.law = buildBallTree(cubes);
	body.volume = without.volume = double(cubes.size()) * kSide * kSide * kSide;
	body.levels = without.levels = buildLevels(body.law);
	for (BallTree& level : without.levels) level.gradients = {};
	ASSERT_GE(body.levels.size(), 3u);
	QueryWorkspace workspace;
	QueryOptions options;
	const auto force = [&](const InnerSphereTree& tree, const Pose& X, int level) {
		options.level = level;
		return pressureWrench(queryOverlap(tree, tree, X, workspace, options).total, {}).force;
	};
	std::mt19937 random(8);
	std::uniform_real_distribution<double> u(-1, 1);
	for (const int level : {2, 4, 6})
	{
		double off = 0, offWithout = 0;
		constexpr int kPoses = 20;
		for (int i = 0; i < kPoses; ++i)
		{
			Vec3 direction{u(random), u(random), u(random)};
			direction = direction / norm(direction);
			const Pose X{rotationMatrix(quaternionFromRotationVector({3 * u(random), 3 * u(random), 3 * u(random)})), direction * 1.2};
			const Vec3 exact = force(body, X, 0);
			off += dot(force(body, X, level) - exact, exact) / squaredNorm(exact) / kPoses;
			offWithout += dot(force(without, X, level) - exact, exact) / squaredNorm(exact) / kPoses;
		}
		EXPECT_LT(offWithout, -0.005) << "else this test shows nothing; level " << level;
		EXPECT_LT(std::fabs(off), std::fabs(offWithout) / 3) << "level " << level;
	}
}

TEST(TreeLevels, FewBallsHaveNoLevels)
{
	EXPECT_TRUE(buildLevels(BallTree{}).empty());
	EXPECT_TRUE(buildLevels(buildBallTree(cloud(20, 1, 0))).empty());
}

// There are 32 groups far apart, each of three lumps of three leaves, and no leaf is in the middle of a larger cluster. So the cuts are
// the lumps and the groups.
TEST(TreeLevels, ASphereHasTheCoarsestLevelAtWhichItLeads)
{
	constexpr int kGroups = 32;
	constexpr float kLumps[] = {0, 30, 100};
	std::mt19937 random(8);
	std::uniform_real_distribution<float> u(-1, 1);
	std::vector<uint32_t> names(9 * kGroups);
	std::iota(names.begin(), names.end(), 0u);
	std::shuffle(names.begin(), names.end(), random);
	std::vector<MomentEllipsoid> balls;
	std::vector<int> expected(names.size(), 0);
	for (int group = 0; group < kGroups; ++group)
	{
		const auto first = names.begin() + 9 * group;
		for (int leaf = 0; leaf < 9; ++leaf)
		{
			Sphere sphere;
			sphere.x = 10000.0f * float(group) + kLumps[leaf / 3] + u(random);
			sphere.y = u(random);
			sphere.z = u(random);
			sphere.r = 0.1f;
			balls.push_back(ballOf(sphere, first[leaf]));
		}
		for (int lump = 0; lump < 3; ++lump) expected[*std::min_element(first + 3 * lump, first + 3 * lump + 3)] = 1;
		expected[*std::min_element(first, first + 9)] = 2;
	}
	EXPECT_EQ(levelsOfSpheres(buildBallTree(balls), names.size()), expected);
}

TEST(TreeLevels, NoMoreSpheresLeadThanALevelHasBalls)
{
	std::vector<MomentEllipsoid> balls = cloud(5000, 3, 0);
	for (size_t i = 0; i < balls.size(); ++i) balls[i].sphere = uint32_t(i * 7919 % balls.size() / 2);
	const BallTree leaves = buildBallTree(balls);
	const std::vector<BallTree> levels = buildLevels(leaves);
	const std::vector<int> ofSpheres = levelsOfSpheres(leaves, 2500);
	EXPECT_EQ(ofSpheres[0], int(levels.size())) << "nothing is larger than the largest";
	for (int level = 1; level <= int(levels.size()); ++level)
	{
		const auto leading = size_t(std::count_if(ofSpheres.begin(), ofSpheres.end(), [&](int own) { return own >= level; }));
		EXPECT_LE(leading, levels[size_t(level - 1)].ballCount());
		EXPECT_GT(leading, levels[size_t(level - 1)].ballCount() / 4) << level;
	}
	// There are too few balls for a second level.
	EXPECT_EQ(levelsOfSpheres(buildBallTree(cloud(40, 1, 0)), 3), std::vector<int>(3, 0));
}
