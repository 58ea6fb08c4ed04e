// SPDX-License-Identifier: Zlib
#pragma once

#include <BulletISTCollision/Core/Build/TreeBuilder.h>
#include <BulletISTCollision/Core/Mesh/MeshShapes.h>

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

inline std::shared_ptr<const ist::InnerSphereTree> unitCube()
{
	ist::BuildOptions options;
	options.maxSpheres = 500;
	ist::Result<ist::InnerSphereTree> cube = ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options);
	if (!cube)
	{
		std::fprintf(stderr, "%s\n", cube.error().message.c_str());
		std::exit(1);
	}
	return std::make_shared<const ist::InnerSphereTree>(std::move(cube).value());
}

/// A unit cube of 1 kg above the plane y = 0, and the plane.
struct CubeOnPlane
{
	btBoxShape cubeShape{btVector3(.5, .5, .5)};
	btStaticPlaneShape planeShape{btVector3(0, 1, 0), 0};
	btRigidBody cube{body(1, &cubeShape)};
	btRigidBody plane{body(0, &planeShape)};

	explicit CubeOnPlane(btDynamicsWorld& w) : world(w)
	{
		cube.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(.55), 0)));
		world.addRigidBody(&plane);
		world.addRigidBody(&cube);
	}
	~CubeOnPlane()
	{
		world.removeRigidBody(&cube);
		world.removeRigidBody(&plane);
	}
	static btRigidBody::btRigidBodyConstructionInfo body(btScalar mass, btCollisionShape* shape)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(mass, inertia);
		return {mass, nullptr, shape, inertia};
	}

	btDynamicsWorld& world;
};

/// What main returns: 0 when the cube lies on the plane, to within 5 cm, and does not move.
inline int verdict(const btRigidBody& cube, size_t contacts)
{
	const double height = double(cube.getWorldTransform().getOrigin().y()), speed = double(cube.getLinearVelocity().length());
	std::printf("%zu-byte scalars: height %g m, speed %g m/s, %zu contact(s)\n", sizeof(btScalar), height, speed, contacts);
	return std::fabs(height - .5) < .05 && speed < .05 && contacts == 1 ? 0 : 1;
}
