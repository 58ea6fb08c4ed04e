// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

using namespace scenario;
using ist::Vec3;

// On a plane and on one of Bullet's boxes nothing but friction holds back what slides, on which edge or corner it may stand. On the box
// each of these stopped within a second, but for the face and edges along the way.
TEST(Sliding, WithoutFrictionNothingHoldsBackOnAPlaneOrABox)
{
	static const Solid cube(ist::makeBoxMesh({0.1, 0.1, 0.1}), 1000);
	const Vec3 corner = std::acos(1 / std::sqrt(3.0)) * ist::normalized({1, 0, -1});
	for (const double rate : {60.0, 240.0, 1000.0})
		for (const bool onBox : {false, true})
			for (const Vec3& turn : {Vec3{}, Vec3{0, 0, 0.785}, Vec3{0, 0, 0.26}, Vec3{0.785, 0, 0}, Vec3{0.3, 0.4, 0.5}, corner})
			{
				SCOPED_TRACE(testing::Message()
					<< (onBox ? "box, " : "plane, ") << rate << " Hz, turned by " << turn.x << " " << turn.y << " " << turn.z);
				Scene scene;
				scene.world.setGravity(btVector3(0, btScalar(-9.81), 0));
				btRigidBody* floor = onBox ? scene.add(scene.shape<btBoxShape>(vec(Vec3{4, 0.2, 2})), 0, 0, at({0, -0.2, 0}))
										   : scene.addFloor();
				ist::Pose X;
				X.rotation = ist::rotationMatrix(ist::quaternionFromRotationVector(turn));
				btRigidBody* body = scene.add(scene.volumetricShape(cube), 8, 0.05, at({-2, -lowestPoint(cube.mesh, X), 0.1}, turn));
				for (btRigidBody* b : {floor, body}) b->setFriction(0);
				body->setAngularFactor(btScalar(0));
				scene.run(0.3, rate);
				body->setLinearVelocity(btVector3(1, body->getLinearVelocity().y(), 0));
				scene.run(1, rate);
				EXPECT_NEAR(double(body->getLinearVelocity().x()), 1, 1e-3);
			}
}
