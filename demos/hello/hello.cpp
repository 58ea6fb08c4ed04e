// SPDX-License-Identifier: Zlib
// A ring lies on Bullet's plane, a second one falls on it. Prints where they come to rest and what the floor feels.
// Usage: hello [FILE.ist]          (an .ist file comes from `ist build MESH -o FILE.ist`)
#include "BulletHapticForce/btBulletHapticForceCommon.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

int main(int argc, char** argv)
{
	// 1. A tree of inner spheres. A game builds it once and keeps it in a file.
	ist::BuildOptions options;
	options.maxSpheres = 1000;
	ist::Result<ist::InnerSphereTree> made = argc > 1 ? ist::loadAsset(argv[1]) : ist::buildTree(ist::makeTorusMesh(0.35, 0.15), options);
	if (!made)
	{
		std::fprintf(stderr, "%s\n", made.error().message.c_str());
		return 1;
	}
	const auto tree = std::make_shared<const ist::InnerSphereTree>(std::move(made).value());

	// 2. Any Bullet shape that is as large as the mesh. Contact comes from the tree; the shape serves the broad phase and ray tests.
	// Bullet's bodies turn about the origin of their shape: centre your mesh on its centre of mass.
	const ist::Vec3 lower = tree->origin + tree->box.lower, upper = tree->origin + tree->box.upper;
	const ist::Vec3 half = ist::componentMax(upper, -lower);
	btBoxShape shape(btVector3(btScalar(half.x), btScalar(half.y), btScalar(half.z)));
	btStaticPlaneShape plane(btVector3(0, 0, 1), 0);

	// 3. A world: Bullet's own, with our collision algorithm and our solver in their places.
	btISTWorld world;
	world.setGravity(btVector3(0, 0, btScalar(-9.81)));
	auto attachment = world.attach(&shape, tree);  // until it goes, the shape speaks through the tree
	if (!attachment) return 1;

	// 4. Bodies, as in any Bullet program. A material says how stiff they are; without one a rule by weight and size decides.
	const btScalar mass = 10;
	btVector3 inertia;
	shape.calculateLocalInertia(mass, inertia);
	btRigidBody floor(0, nullptr, &plane), lying(mass, nullptr, &shape, inertia), falling(mass, nullptr, &shape, inertia);
	lying.getWorldTransform().setOrigin(btVector3(0, 0, btScalar(-lower.z)));
	falling.getWorldTransform().setOrigin(btVector3(btScalar(0.02), 0, btScalar(upper.z - 2 * lower.z + 0.1)));
	for (btRigidBody* body : {&floor, &lying, &falling}) world.bullet().addRigidBody(body);
	for (btRigidBody* body : {&lying, &falling})
		if (world.materials().set(body, {1e5, 20})) return 1;  // [Pa/m], [s/m]: rebounds end at 1/20 m/s

	// 5. Step, and ask what the contact was. The store holds every pair's overlap, and the impulse of each of its patches on A.
	const double dt = 1.0 / 240;
	double force = 0;
	for (double t = 0; t < 2; t += dt)
	{
		world.bullet().stepSimulation(btScalar(dt), 0);
		force = 0;
		for (const btISTContact* contact : world.contacts().contacts())
			for (int i = 0; contact->halfSpace && i < contact->patchCount; ++i) force += contact->impulses[i].force.z / dt;
	}
	for (const btISTContact* contact : world.contacts().contacts())
		if (contact->patchCount > 0)
			std::printf("%-12s overlap %.4g cm^3 in %d patch(es)\n",
				contact->halfSpace ? "ring, floor:" : "ring, ring:", 1e6 * contact->total.volume, contact->patchCount);
	const double weight = 2 * double(mass) * 9.81,
				 speed = double(std::max(lying.getLinearVelocity().length(), falling.getLinearVelocity().length()));
	std::printf("heights      %.4f m and %.4f m, speed %.1e m/s\n", double(lying.getWorldTransform().getOrigin().z()),
		double(falling.getWorldTransform().getOrigin().z()), speed);
	std::printf("floor feels  %.3f N of %.3f N weight\n", force, weight);
	for (btRigidBody* body : {&floor, &lying, &falling}) world.bullet().removeRigidBody(body);
	return std::fabs(force / weight - 1) < 0.01 && speed < 0.01 ? 0 : 1;
}
