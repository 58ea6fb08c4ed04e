// SPDX-License-Identifier: Zlib
#pragma once

#include "TestSupport/TestWorld.h"

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace ist::test
{
/// How a game makes the body under test: mesh or asset, mass, material, friction. It is called with a world of the scene. It returns one
/// of this world's bodies, in the given pose; the body must be able to move.
using BodyMaker = std::function<btRigidBody&(TestWorld& world, const btTransform& pose)>;

/// A number that a scene has measured, and the value of theory.
struct SceneValue
{
	std::string what;  ///< name and unit of the number
	double measured = 0, expected = 0;
	double scale = 1;  ///< an error is divided by this; usually `expected`, except for values that should be zero

	/// |measured - expected| / scale.
	double error() const;
};
std::ostream& operator<<(std::ostream& stream, const SceneValue& value);

/// A scene whose outcome is known in closed form for every closed body, whatever its shape and material. It tests whether a game's own
/// asset, with its mass, its material and the game's step, behaves as it should. The duration follows from the size of the body. The
/// body's own damping (btRigidBody::setDamping) is switched off.
struct TestScene
{
	const char* name;  ///< letters only, as GoogleTest requires for names of parameters
	const char* law;
	/// Runs the scene in steps of `h` [s]. Throws std::runtime_error with the reason when the body has no tree or cannot move.
	std::vector<SceneValue> (*play)(const BodyMaker& body, double h);
};

/// A body settles on a floor.
std::vector<SceneValue> restOnFloor(const BodyMaker& body, double h = 1.0 / 240);
/// A body that cannot rotate slides down a slope. The tangent of the slope is its friction coefficient plus 0.5. The body's friction is
/// set by btRigidBody::setFriction; that of the slope is 1.
std::vector<SceneValue> slideDownSlope(const BodyMaker& body, double h = 1.0 / 240);
/// A body floats in a fluid of twice its mean density.
std::vector<SceneValue> floatInFluid(const BodyMaker& body, double h = 1.0 / 240);
/// Five copies of the body stand on each other on a floor. In this scene and the next, bodies can only move up and down, so that no shape
/// topples. A body that is too soft for its load gives way, and the test fails.
std::vector<SceneValue> standInTower(const BodyMaker& body, double h = 1.0 / 240);
/// The body lies on a floor and carries a copy with 20 times its mass and, if it is set, 20 times its stiffness.
std::vector<SceneValue> carryHeavyOne(const BodyMaker& body, double h = 1.0 / 240);
/// One copy of the body flies into another, off its centre, without gravity.
std::vector<SceneValue> collideWithItsLike(const BodyMaker& body, double h = 1.0 / 240);

/// All scenes, for a loop or for testing::ValuesIn.
const std::vector<TestScene>& testScenes();
}  // namespace ist::test
