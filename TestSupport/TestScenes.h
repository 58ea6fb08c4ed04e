// SPDX-License-Identifier: Zlib
#pragma once

#include "TestSupport/TestWorld.h"

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace ist::test
{
/// How a game makes the body that is tried: mesh or asset, mass, material, friction. Called with a world of the scene's own; returns one of
/// its bodies, which must move, in that pose.
using BodyMaker = std::function<btRigidBody&(TestWorld& world, const btTransform& pose)>;

/// A number that a scene measured, beside what theory says.
struct SceneValue
{
	std::string what;  ///< with its unit
	double measured = 0, expected = 0;
	double scale = 1;  ///< what an error is compared with: mostly `expected`, but for what should be zero

	/// |measured - expected| / scale.
	double error() const;
};
std::ostream& operator<<(std::ostream& stream, const SceneValue& value);

/// A scene whose outcome is known in closed form for every closed body, whatever its shape and material: it tells whether a game's own
/// asset, with its mass, its material and the game's step, behaves as it should. How long it runs follows from the size of the body, whose
/// own damping (btRigidBody::setDamping) is taken off.
struct TestScene
{
	const char* name;  ///< in letters alone, as GoogleTest wants the names of parameters
	const char* law;
	/// In steps of `h` [s]. Throws std::runtime_error with the reason when the body has no tree or cannot move.
	std::vector<SceneValue> (*play)(const BodyMaker& body, double h);
};

/// A body comes to lie on a floor.
std::vector<SceneValue> restOnFloor(const BodyMaker& body, double h = 1.0 / 240);
/// A body that cannot turn slides down a slope which is steeper than its friction holds, by .5 in the tangent. Its friction is
/// btRigidBody::setFriction; the slope's is 1.
std::vector<SceneValue> slideDownSlope(const BodyMaker& body, double h = 1.0 / 240);
/// A body floats in a fluid of twice its mean density.
std::vector<SceneValue> floatInFluid(const BodyMaker& body, double h = 1.0 / 240);
/// Five of the body stand on each other on a floor. Here and in the next scene bodies are guided: they move up and down and nowhere else,
/// so that no shape topples. A body that is too soft for its load gives way, and fails.
std::vector<SceneValue> standInTower(const BodyMaker& body, double h = 1.0 / 240);
/// The body lies on a floor, and on it its like, of twenty times the mass and, where it has one, the stiffness.
std::vector<SceneValue> carryHeavyOne(const BodyMaker& body, double h = 1.0 / 240);
/// One of the body flies into another, off its centre, without gravity.
std::vector<SceneValue> collideWithItsLike(const BodyMaker& body, double h = 1.0 / 240);

/// All of them, for a loop or for testing::ValuesIn.
const std::vector<TestScene>& testScenes();
}  // namespace ist::test
