// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "tests/unit/Core/Geometry/FieldShapes.h"

#include <cmath>
#include <limits>
#include <random>

using namespace ist;

namespace
{
Vec3 randomPoint(std::mt19937& random, double size)
{
	std::uniform_real_distribution<double> u(-size, size);
	const double x = u(random), y = u(random);
	return {x, y, u(random)};
}

/// Points of a homogeneous ball of this radius, each with its mirror image.
std::vector<Vec3> ballPoints(std::mt19937& random, double radius, int count)
{
	std::vector<Vec3> points;
	while (int(points.size()) < count)
	{
		const Vec3 y = randomPoint(random, 1);
		if (squaredNorm(y) > 1) continue;
		points.push_back(radius * y);
		points.push_back(-radius * y);
	}
	return points;
}
}  // namespace

TEST(AnalyticField, DepthAndNormalAreThoseOfTheNearestPointOfAMesh)
{
	std::mt19937 random(1);
	for (const FieldShape& shape : fieldShapes())
	{
		const MeshDistance mesh(shape.mesh);
		int inside = 0;
		for (int i = 0; i < 400; ++i)
		{
			const Vec3 p = randomPoint(random, 1);
			const double distance = mesh.closest(p).distance, depth = shape.field->depth(p);
			// A chord lies this far inside its arc.
			constexpr double kSagitta = 4e-4;
			if (!mesh.contains(p))
			{
				EXPECT_LE(depth, kSagitta) << shape.name;
				EXPECT_GE(depth, -distance - kSagitta) << shape.name << ": more than the distance, nodes in reach would be dropped";
				continue;
			}
			++inside;
			EXPECT_NEAR(depth, distance, kSagitta) << shape.name;
			const Vec3 n = shape.field->normal(p);
			EXPECT_NEAR(norm(n), 1, 1e-9) << shape.name;
			// The surface is reached after this distance along the normal.
			EXPECT_NEAR(shape.field->depth(p + (depth - 1e-3) * n), 1e-3, 1e-9) << shape.name;
		}
		EXPECT_GT(inside, 15) << shape.name;
		EXPECT_NEAR(shape.field->volume(), massProperties(shape.mesh).volume, 1e-3 * shape.field->volume()) << shape.name;
	}
}

TEST(AnalyticField, SidesSeenByACloudAreMeansOverItsPoints)
{
	std::mt19937 random(2);
	for (const FieldShape& shape : fieldShapes())
		for (const double radius : {0.03, 0.1})
		{
			const std::vector<Vec3> cloud = ballPoints(random, radius, 2000);
			SymmetricMatrix3 spread;
			for (const Vec3& y : cloud) spread += SymmetricMatrix3::square(y) * (1.0 / double(cloud.size()));
			for (int i = 0; i < 20; ++i)
			{
				const Vec3 p = randomPoint(random, 0.6);
				for (int s = 0; s < shape.field->sideCount(); ++s)
				{
					double depth = 0;
					Vec3 normal;
					for (const Vec3& y : cloud)
					{
						const FieldSide point = shape.field->side(s, p + y, {});
						depth += point.depth / double(cloud.size());
						normal += point.normal / double(cloud.size());
					}
					const FieldSide mean = shape.field->side(s, p, spread);
					// For a cloud on an axis or a centre the means are rounded off; there they differ by up to 5 %.
					EXPECT_NEAR(mean.depth, depth, 0.06 * radius) << shape.name << " side " << s;
					EXPECT_LT(norm(mean.normal - normal), 0.12) << shape.name << " side " << s;
				}
			}
		}
}

TEST(AnalyticField, BendIsTheDerivativeOfTheNormal)
{
	std::mt19937 random(3);
	const double h = 1e-6;
	for (const FieldShape& shape : fieldShapes())
		for (int i = 0; i < 50; ++i)
		{
			const Vec3 p = randomPoint(random, 0.6);
			if (std::hypot(p.x, p.y) < 0.05) continue;
			for (int s = 0; s < shape.field->sideCount(); ++s)
			{
				const SymmetricMatrix3 bend = shape.field->side(s, p, {}).bend;
				for (const Vec3& e : {Vec3{h, 0, 0}, Vec3{0, h, 0}, Vec3{0, 0, h}})
				{
					const Vec3 rise = (shape.field->side(s, p + e, {}).normal - shape.field->side(s, p - e, {}).normal) / 2.0;
					EXPECT_LT(norm(rise - bend * e), 1e-3 * h * std::max(1.0, bend.trace())) << shape.name << " side " << s;
				}
			}
		}
}

TEST(AnalyticField, RefusesLengthsThatAreNone)
{
	const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
	for (const double bad : {0.0, -1.0, nan, inf})
	{
		EXPECT_FALSE(BoxField({1, bad, 1}).isValid()) << bad;
		EXPECT_FALSE(SphereField(bad).isValid()) << bad;
		EXPECT_FALSE(CapsuleField(bad, 1).isValid()) << bad;
		EXPECT_FALSE(CylinderField(bad, 1).isValid()) << bad;
		EXPECT_FALSE(CylinderField(1, bad).isValid()) << bad;
		EXPECT_FALSE(ConeField(bad, 1).isValid()) << bad;
		EXPECT_FALSE(ConeField(1, bad).isValid()) << bad;
	}
	EXPECT_TRUE(CapsuleField(1, 0).isValid());
	EXPECT_FALSE(CapsuleField(1, -1).isValid());
	EXPECT_FALSE(BoxField({1e-200, 1e-200, 1}).isValid()) << "a volume of zero";
	EXPECT_FALSE(HalfSpaceField({0, 0, 2}, 0).isValid());
	EXPECT_FALSE(HalfSpaceField({0, 0, 1}, nan).isValid());
}
