// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Geometry/Lens.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "tests/unit/Core/Geometry/FieldShapes.h"
#include "tests/unit/Core/Query/QueryBodies.h"
#include "tests/unit/CountingAllocator.h"

#include <algorithm>
#include <cmath>
#include <random>

using namespace ist;

namespace
{
Vec3 randomVector(std::mt19937& random, double size)
{
	std::uniform_real_distribution<double> u(-size, size);
	const double x = u(random), y = u(random);
	return {x, y, u(random)};
}

Pose randomPose(std::mt19937& random, const Vec3& about, double size)
{
	return {rotationMatrix(quaternionFromRotationVector(randomVector(random, 2))), about + randomVector(random, size)};
}

/// Sums over a grid of points in one ellipsoid.
struct GridSums
{
	double volume = 0, depth = 0;
	Vec3 normal, moment;

	GridSums(const MomentEllipsoid& leaf, const Mat3& Q, const Vec3& axes, const AnalyticField& field, const Pose& X_AF)
	{
		constexpr int kLines = 36;
		const Pose X_FA = inverse(X_AF);
		double all = 0;
		for (int i = 0; i < kLines; ++i)
			for (int j = 0; j < kLines; ++j)
				for (int k = 0; k < kLines; ++k)
				{
					const Vec3 y{(2 * i + 1.0) / kLines - 1, (2 * j + 1.0) / kLines - 1, (2 * k + 1.0) / kLines - 1};
					if (squaredNorm(y) > 1) continue;
					++all;
					const Vec3 x = leaf.center() + Q * Vec3{axes.x * y.x, axes.y * y.y, axes.z * y.z}, p = X_FA * x;
					const double d = field.depth(p);
					if (d <= 0) continue;
					++volume;
					depth += d;
					normal += X_AF.rotation * field.normal(p);
					moment += x;
				}
		const double each = leaf.volume() / all;
		volume *= each;
		depth *= each;
		normal *= each;
		moment *= each;
	}
};

struct RandomLeaf
{
	MomentEllipsoid leaf;
	Mat3 Q;
	Vec3 axes;

	RandomLeaf(std::mt19937& random, const Vec3& center, double size)
	{
		std::uniform_real_distribution<double> share(0.3, 1);
		axes = {size, size * share(random), size * share(random)};
		Q = rotationMatrix(quaternionFromRotationVector(randomVector(random, 2)));
		leaf = ballAt(center, {0.1, 0.2, -0.3}, size * (1 + 1e-6));
		leaf.setShape(rotated(Q, {axes.x * axes.x, axes.y * axes.y, axes.z * axes.z, 0, 0, 0}));
	}
};

/// Query with A moved by `shift`.
OverlapIntegrals queryAt(const InnerSphereTree& A, const AnalyticField& field, Pose X, const Vec3& shift, QueryWorkspace& workspace)
{
	X.translation -= shift;
	return queryField(A, field, X, workspace).total;
}
}  // namespace

// A leaf can be as large as the field, or larger. The test requires that the model of a leaf has an error of a few per cent of the leaf
// and no bias.
TEST(FieldQuery, LeafSharesWhatAGridOfItsPointsSays)
{
	std::mt19937 random(4);
	QueryWorkspace workspace;
	for (const FieldShape& shape : fieldShapes())
		for (const double size : {0.05, 0.2, 0.6})
		{
			double volume = 0, bias = 0, normal = 0, depth = 0, moment = 0;
			int count = 0;
			while (count < 30)
			{
				const Vec3 place = randomVector(random, 1);
				if (std::fabs(shape.field->depth(place)) > 0.8 * size) continue;
				++count;
				const Pose X = randomPose(random, {3, -2, 5}, 1);
				const RandomLeaf l(random, X * place, size);
				const GridSums grid(l.leaf, l.Q, l.axes, *shape.field, X);
				const OverlapIntegrals found = queryField(bodyOf({l.leaf}), *shape.field, X, workspace).total;
				const double whole = l.leaf.volume();
				volume += std::pow((found.volume - grid.volume) / whole, 2);
				bias += (found.volume - grid.volume) / whole;
				normal += squaredNorm(found.normalB.force - grid.normal) / (whole * whole);
				depth += std::pow((found.depthB - grid.depth) / (whole * size), 2);
				moment += squaredNorm(found.firstMoment - grid.moment - (found.volume - grid.volume) * l.leaf.center()) /
					std::pow(whole * size, 2);
				EXPECT_NEAR(found.volume, grid.volume, 0.05 * whole) << shape.name << " " << size;
			}
			const auto rms = [&](double squares) { return std::sqrt(squares / count); };
			EXPECT_LT(rms(volume), 0.015) << shape.name << " " << size;
			EXPECT_LT(std::fabs(bias / count), 0.01) << shape.name << " " << size;
			EXPECT_LT(rms(normal), 0.02) << shape.name << " " << size;
			EXPECT_LT(rms(depth), 0.005) << shape.name << " " << size;
			EXPECT_LT(rms(moment), 0.01) << shape.name << " " << size;
		}
}

// Away from edges a box is a half-space, and the intersection of a small ball with a large one is a lens.
TEST(FieldQuery, FaceOfABoxAndLensOfTwoBallsHaveTheClosedForm)
{
	QueryWorkspace workspace;
	std::mt19937 random(5);
	const double R = 0.2, height = 0.07;
	for (int i = 0; i < 10; ++i)
	{
		const Pose X = randomPose(random, {-8, 4, 1}, 3);
		const InnerSphereTree A = bodyOf({ballAt(X * Vec3{0.1, 0.2, 1 + height}, {0, 0, -0.5}, R)});
		const OverlapIntegrals face = queryField(A, BoxField({3, 3, 1}), X, workspace).total;
		const double h = R - height, cap = kPi * h * h * (3 * R - h) / 3;
		EXPECT_NEAR(face.volume, cap, 2e-5 * cap);
		expectNear(face.normalB.force, cap * X.rotation.column(2), 2e-5 * cap);
		expectNear(face.areaVector, kPi * h * (2 * R - h) * X.rotation.column(2), 2e-5);
		EXPECT_NEAR(face.depthB, kPi * h * h * h * (4 * R - h) / 12, 1e-4 * cap);

		const double big = 2.5, D = big + 0.3 * R;
		const InnerSphereTree B = bodyOf({ballAt(X * (D * normalized(randomVector(random, 1))), {}, R)});
		const OverlapIntegrals ball = queryField(B, SphereField(big), X, workspace).total;
		const double s = R + big - D,
					 lens = kPi * s * s * (D * D + 2 * D * R - 3 * R * R + 2 * D * big + 6 * R * big - 3 * big * big) / (12 * D);
		EXPECT_NEAR(ball.volume, lens, 3e-3 * lens);
	}
}

TEST(FieldQuery, HalfSpaceIsAsFarAwayAsItIsNear)
{
	const InnerSphereTree A = cloudBody(2000, 7);
	QueryWorkspace workspace;
	const Vec3 n = normalized({1, -2, 0.5});
	const OverlapIntegrals direct = queryHalfSpace(A, n, 0.1, workspace).total;
	std::mt19937 random(6);
	const Pose X = randomPose(random, {}, 1000);
	const Vec3 nF = transpose(X.rotation) * n;
	const OverlapIntegrals turned = queryField(A, HalfSpaceField(nF, 0.1 - dot(n, X.translation)), X, workspace).total;
	EXPECT_NEAR(turned.volume, direct.volume, 1e-9 * direct.volume);
	EXPECT_EQ(turned.pairs, direct.pairs);
	for (int i = 0; i < 21; ++i) EXPECT_NEAR(turned.stiffnessB.m[i], direct.stiffnessB.m[i], 1e-8);
}

// Half the step gives half the change: nothing jumps, whichever decisions change along the path.
TEST(FieldQuery, NothingLeapsAlongAPath)
{
	std::mt19937 random(8);
	QueryWorkspace workspace;
	for (const FieldShape& shape : fieldShapes())
	{
		std::vector<MomentEllipsoid> leaves;
		for (const double size : {0.03, 0.1, 0.25, 0.25, 0.5}) leaves.push_back(RandomLeaf(random, randomVector(random, 0.3), size).leaf);
		const InnerSphereTree A = bodyOf(leaves);
		double whole = 0;
		for (const MomentEllipsoid& l : leaves) whole += l.volume();
		const Vec3 axis = normalized(randomVector(random, 1)), aside = 0.3 * normalized(randomVector(random, 1));
		const auto at = [&](double t) {
			const Pose X{rotationMatrix(quaternionFromRotationVector((1.5 * t) * axis)), aside + (2.4 * t - 1.2) * Vec3{0.6, 0.64, 0.48}};
			return queryField(A, *shape.field, X, workspace).total;
		};
		const auto largestStep = [&](int steps) {
			double largest = 0;
			OverlapIntegrals last = at(0);
			for (int i = 1; i <= steps; ++i)
			{
				const OverlapIntegrals now = at(double(i) / steps);
				largest = std::max({largest, std::fabs(now.volume - last.volume), norm(now.normalB.force - last.normalB.force),
					norm(now.normalA.force - last.normalA.force), norm(now.normalB.torque - last.normalB.torque),
					std::fabs(now.depthB - last.depthB), norm(now.firstMoment - last.firstMoment)});
				last = now;
			}
			return largest / whole;
		};
		const double coarse = largestStep(250), fine = largestStep(4000);
		EXPECT_GT(coarse, 1e-3) << shape.name;
		EXPECT_LT(fine, 1.5 * coarse / 16) << shape.name;
	}
}

TEST(FieldQuery, StiffnessAndAreaAreDerivatives)
{
	std::mt19937 random(9);
	QueryWorkspace workspace;
	const double h = 1e-4;
	for (const FieldShape& shape : fieldShapes())
	{
		// Many small leaves side by side form a homogeneous block.
		std::vector<MomentEllipsoid> balls;
		for (int i = 0; i < 8000; ++i)
		{
			balls.push_back(ballAt({0.05 * (i % 20) - 0.5, 0.05 * (i / 20 % 20) - 0.5, 0.05 * (i / 400) - 0.5}, {0, 0, -1}, 0.031));
			balls.back().density = float(0.05 * 0.05 * 0.05 / ballVolume(0.031));
		}
		const InnerSphereTree A = bodyOf(balls);
		for (int trial = 0; trial < 3; ++trial)
		{
			const Pose X = randomPose(random, 0.6 * normalized(randomVector(random, 1)), 0.1);
			const OverlapIntegrals sums = queryField(A, *shape.field, X, workspace).total;
			const double scale = norm(sums.areaVector);
			for (int axis = 0; axis < 3; ++axis)
			{
				Vec3 e;
				e[axis] = h;
				const OverlapIntegrals up = queryAt(A, *shape.field, X, e, workspace), down = queryAt(A, *shape.field, X, -e, workspace);
				EXPECT_NEAR(-(up.volume - down.volume) / (2 * h), sums.areaVector[axis], 0.03 * scale) << shape.name;
				const Vec3 force = (down.normalB.force - up.normalB.force) / (2 * h);
				for (int row = 0; row < 3; ++row)
					EXPECT_NEAR(force[row], sums.stiffnessB(row, axis), 0.06 * scale) << shape.name << row << axis;
				EXPECT_NEAR((down.depthB - up.depthB) / (2 * h), sums.normalB.force[axis], 0.01 * sums.volume) << shape.name;
				// All normals of A are -z, so only this column equals its own transpose.
				if (axis < 2) continue;
				EXPECT_NEAR((up.normalA.force.z - down.normalA.force.z) / (2 * h), sums.stiffnessA(2, 2), 0.03 * scale) << shape.name;
			}
		}
	}
}

TEST(FieldQuery, FacesOfABoxArePatchesOfTheirOwnAndSumToTheWhole)
{
	const InnerSphereTree A = cloudBody(3000, 10, {4, 5, 6});
	QueryWorkspace workspace;
	// The box's edge along y is in the middle of the cloud.
	const Pose X{Mat3{}, Vec3{4, 5, 6} - Vec3{1.5, 0, 1.5}};
	const OverlapResult r = queryField(A, BoxField({1.5, 3, 1.5}), X, workspace);
	ASSERT_EQ(r.patchCount, 2);
	OverlapIntegrals sum;
	bool alongX = false, alongZ = false;
	for (int p = 0; p < 2; ++p)
	{
		sum.add(r.patches[p]);
		const Vec3 n = normalized(r.patches[p].normalB.force);
		alongX |= n.x > 0.98;
		alongZ |= n.z > 0.98;
	}
	EXPECT_TRUE(alongX && alongZ);
	EXPECT_NEAR(sum.volume, r.total.volume, 1e-9);
	expectNear(sum.normalB.torque, r.total.normalB.torque, 1e-9);
	QueryOptions whole;
	whole.patches = false;
	const OverlapResult one = queryField(A, BoxField({1.5, 3, 1.5}), X, workspace, whole);
	EXPECT_EQ(one.patchCount, 1);
	EXPECT_NEAR(one.total.volume, r.total.volume, 1e-9);
}

TEST(FieldQuery, FarBodiesShareNothingAndBadOnesAreRefused)
{
	const InnerSphereTree A = cloudBody(300, 11);
	QueryWorkspace workspace;
	for (const FieldShape& shape : fieldShapes())
	{
		Pose X;
		X.translation = {0, 0, 5};
		const OverlapResult far = queryField(A, *shape.field, X, workspace);
		EXPECT_EQ(far.status, QueryStatus::Ok);
		EXPECT_EQ(far.patchCount, 0);
		EXPECT_EQ(far.total.pairs, 0);
		EXPECT_EQ(far.total.volume, 0);
		EXPECT_EQ(norm(far.total.normalB.force), 0);
		X.translation.x = std::nan("");
		EXPECT_EQ(queryField(A, *shape.field, X, workspace).status, QueryStatus::InvalidPose);
		QueryOptions budget, level, share;
		budget.maxPairs = 10;
		level.level = 1;
		share.otherShare = 0.5;
		for (const QueryOptions& options : {budget, level, share})
			EXPECT_EQ(queryField(A, *shape.field, {}, workspace, options).status, QueryStatus::Unsupported);
	}
	EXPECT_EQ(queryField(A, SphereField(0), {}, workspace).status, QueryStatus::InvalidPose);
	EXPECT_EQ(queryField(A, ConeField(1, -1), {}, workspace).status, QueryStatus::InvalidPose);
	EXPECT_EQ(queryField({}, SphereField(1), {}, workspace).status, QueryStatus::EmptyTree);
}

// The sizes range from a field that contains the whole body to one that is a millionth of the leaf that contains it.
TEST(FieldQuery, FieldsOfAnySizeGiveFiniteSums)
{
	QueryWorkspace workspace;
	const InnerSphereTree A = bodyOf({ballAt({0.1, 0, 0}, {0, 0, 0.5}, 0.5)});
	const auto expectSums = [&](const AnalyticField& field, double size) {
		const OverlapIntegrals sums = queryField(A, field, {}, workspace).total;
		EXPECT_TRUE(isFinite(sums.normalB) && isFinite(sums.areaVector) && std::isfinite(sums.depthB));
		for (const double k : sums.stiffnessB.m) EXPECT_TRUE(std::isfinite(k));
		// A large field contains the leaf. A small field lies inside the leaf, which then counts as a box and is 13 % denser than the
		// ball.
		const double expected = std::min(field.volume(), ballVolume(0.5));
		const double tolerance = size <= 0.1 ? 0.16 : size >= 100 ? 1e-6 : 1;
		EXPECT_NEAR(sums.volume, expected, tolerance * expected) << size;
	};
	for (const double size : {1e-6, 1e-3, 0.1, 1.0, 100.0, 1e6})
	{
		expectSums(BoxField({size, size, size}), size);
		expectSums(SphereField(size), size);
		expectSums(CapsuleField(size, size), size);
		expectSums(CylinderField(size, size), size);
		expectSums(ConeField(size, 2 * size), size);
	}
}

TEST(FieldQuery, OverflowKeepsTheSumsAndAllocatesNothing)
{
	const InnerSphereTree A = cloudBody(3000, 12);
	QueryWorkspace roomy, tight({100, 8, 65536});
	const BoxField box({0.7, 0.8, 0.9});
	const OverlapResult all = queryField(A, box, {}, roomy), cut = queryField(A, box, {}, tight);
	EXPECT_TRUE(all.pairListComplete);
	EXPECT_FALSE(cut.pairListComplete);
	EXPECT_EQ(cut.patchCount, 1);
	EXPECT_NEAR(cut.total.volume, all.total.volume, 1e-9);
	EXPECT_EQ(cut.total.pairs, all.total.pairs);
	expectNear(cut.total.normalA.torque, all.total.normalA.torque, 1e-9);
	const auto before = allocationCount();
	for (int i = 0; i < 20; ++i)
	{
		Pose X;
		X.translation = {0.05 * i, 0.02 * i, 0};
		queryField(A, box, X, roomy);
		queryField(A, SphereField(0.5), X, roomy);
		queryField(A, ConeField(0.5, 1), X, tight);
	}
	EXPECT_EQ(allocationCount(), before);
}
