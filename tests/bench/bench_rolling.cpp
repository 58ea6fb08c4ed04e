// SPDX-License-Identifier: Zlib
// What a ball loses that rolls on flat ground with nothing set, as a mesh of more and fewer triangles and spheres: 1 kg, radius 0.5 m,
// 5 m/s, friction 0.7, for 3 s. Finer triangles change what the facets take, more spheres what the leaves take; what stays is the law's.
// Usage: bench_rolling
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "TestSupport/TestWorld.h"

#include <cstdio>

namespace
{
constexpr double kRadius = 0.5, kSpeed = 5, kTime = 3;

enum class Ground
{
	Plane,
	Tree
};

/// Speed after kTime [m/s].
double speedAfter(const ist::Mesh& ball, int spheres, Ground ground, double rate)
{
	using ist::test::at;
	constexpr double kHalf = 30, kThick = 0.5;
	ist::test::TestWorld world(spheres);
	btRigidBody& floor = ground == Ground::Plane ? world.addFloor()
												 : world.addMesh(ist::makeBoxMesh({kHalf, kThick, kHalf}), 0, at(0, -kThick, 0));
	floor.setFriction(btScalar(0.7));
	btRigidBody& body = world.addMesh(ball, 1, at(0, kRadius, 0));
	body.setFriction(btScalar(0.7));
	world.run(0.5, 1 / rate);
	body.setLinearVelocity(btVector3(btScalar(kSpeed), 0, 0));
	body.setAngularVelocity(btVector3(0, 0, btScalar(-kSpeed / kRadius)));
	world.run(kTime, 1 / rate);
	return double(body.getLinearVelocity().length());
}
}  // namespace

int main()
{
	std::printf("speed after %g s [m/s], of %g\n%9s %8s  %7s %7s  %7s %7s\n%9s %8s  %7s %7s  %7s %7s\n", kTime, kSpeed, "triangles",
		"spheres", "plane", "", "tree", "", "", "", "60 Hz", "240 Hz", "60 Hz", "240 Hz");
	for (const int level : {4, 6})
	{
		const ist::Mesh ball = ist::makeSphereMesh(kRadius, level);
		for (const int spheres : {1000, 10000})
		{
			std::printf("%9zu %8d ", ball.triangles.size(), spheres);
			for (const Ground ground : {Ground::Plane, Ground::Tree})
			{
				std::printf(" ");
				for (const double rate : {60., 240.})
				{
					std::printf("%7.4f ", speedAfter(ball, spheres, ground, rate));
					std::fflush(stdout);
				}
			}
			std::printf("\n");
		}
	}
}
