// SPDX-License-Identifier: Zlib
// A cube of 1,000 kg/m^3 comes to rest on a table, all from memory.
#include <BulletHapticForce/btBulletHapticForceCommon.h>
#include <BulletISTCollision/Core/Base/Version.h>
#include <BulletISTCollision/Core/Build/TreeBuilder.h>
#include <BulletISTCollision/Core/Mesh/MeshShapes.h>

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>

int main()
{
	ist::BuildOptions options;
	options.maxSpheres = 500;
	ist::Result<ist::InnerSphereTree> tree = ist::buildTree(ist::makeBoxMesh({.05, .05, .05}), options);
	if (!tree) return std::puts(tree.error().message.c_str()), 1;

	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	btISTWorld ist(world);

	btBoxShape cubeShape(btVector3(.05, .05, .05));
	const auto attachment = ist.attach(&cubeShape, std::make_shared<const ist::InnerSphereTree>(std::move(tree).value()));
	btVector3 inertia;
	cubeShape.calculateLocalInertia(1, inertia);
	btRigidBody cube(1, nullptr, &cubeShape, inertia);
	cube.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, .06, 0)));
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	btRigidBody table(0, nullptr, &plane);
	world.addRigidBody(&cube);
	world.addRigidBody(&table);
	for (int i = 0; i < 240; ++i) world.stepSimulation(1. / 120, 0);

	const double height = cube.getWorldTransform().getOrigin().y();
	std::printf("BulletHaptics %s: the cube rests at %.4f m\n", BULLETHAPTICS_VERSION, height);
	world.removeRigidBody(&cube);
	world.removeRigidBody(&table);
	return std::fabs(height - .05) < .002 ? 0 : 1;
}
