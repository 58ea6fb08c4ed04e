// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Base/Result.h"

#include <cmath>
#include <optional>
#include <unordered_map>

class btDynamicsWorld;

/// What a body is made of, for the pressure field law. Friction stays where Bullet has it: btCollisionObject::setFriction.
struct btContactMaterial
{
	double stiffness = 0;     ///< k_X [Pa/m]: pressure at a depth, per depth. 0: not set
	double dissipation = -1;  ///< Hunt-Crossley [s/m]; nothing leaves contact faster than its inverse. Negative: not set
	double fluidDensity = 0;  ///< [kg/m^3] of a fluid that fills a half-space; 0: a solid

	/// A fluid: for a static plane (btStaticPlaneShape) whose normal points against gravity. Its pressure is that of hydrostatics, density
	/// times gravity times depth, whatever floats in it is made of; it drags nothing along unless it is given a dissipation. The body's
	/// friction stays what Bullet has: a fluid wants setFriction(0). Bodies need trees; waves and added mass are not modelled.
	static btContactMaterial fluid(double density) { return {0, -1, density}; }
	/// Elastic foundation: modulus [Pa] over the depth [m] of the layer that yields.
	static btContactMaterial fromModulus(double modulus, double foundationDepth) { return {modulus / foundationDepth, -1}; }
};

/// Decides the constants of a pair from the materials of its bodies:
/// (a) against a half-space all weight lies on its field, whatever the materials; against a fluid k is its density times gravity,
/// and the dissipation is that of the fluid, or none;
/// (b) both stiffnesses set: in series, 1/k = 1/k_A + 1/k_B, w_A = k_B/(k_A + k_B): the softer body's field counts more;
/// (c) one set: k is that one, all weight on its field;
/// (d) none set: btISTDefaultPairRule. The solver raises k for the weight of all bodies that hang together with the two through contacts,
/// and lowers it where the step could not bear it (carryLoad in btContactLaw.h). Dissipation: d = (k_B d_A + k_A d_B)/(k_A + k_B) when both
/// stiffnesses and both dissipations are set, else the mean of those set, else that of (d). One owner thread: that of the world.
class btContactMaterialTable : public btISTPairRule
{
public:
	// Bodies of a centimetre and more rest with these, all at once, in steps of up to 1/60 s; a little beyond them one is flung away or
	// falls through.
	static constexpr double kStiffest = 1e15;        ///< [Pa/m]: steel, of which a fifth of a millimetre yields
	static constexpr double kMostDissipation = 1e6;  ///< [s/m]
	static constexpr double kDensest = 1e12;         ///< of a fluid [kg/m^3]: its pressure rises by kStiffest in 1000 m/s^2

	/// See setGravity.
	explicit btContactMaterialTable(double gravity = 9.81) : m_gravity(9.81) { setGravity(gravity); }

	/// Refused, with the reason: values that are not finite or beyond those above, a negative stiffness or density, a fluid that is no
	/// plane or has a stiffness. Call `remove` before the body is deleted: its address may be given to a new one.
	std::optional<ist::Error> set(const btCollisionObject* body, const btContactMaterial& material);
	void remove(const btCollisionObject* body) { m_materials.erase(body); }
	/// That of `set`, or one with nothing set.
	btContactMaterial find(const btCollisionObject* body) const;
	/// Magnitude of gravity [m/s^2], for fluids and, in (d), for bodies without a gravity of their own. Ignored when negative or not
	/// finite. In (d) zero keeps the former one: bodies without weight shall not become bodies without contact.
	void setGravity(double gravity);
	/// Takes the gravity of `world` instead, as it is whenever a pair is decided. The world must stay until this is called again; null
	/// keeps the last gravity of the former world.
	void followGravity(const btDynamicsWorld* world);
	/// In force now [m/s^2].
	double gravity() const;

	btISTPairConstants decide(const btISTContact& contact, const btCollisionObject* bodyA, const btCollisionObject* bodyB) const override;

private:
	const btDynamicsWorld* m_world = nullptr;  // whose gravity is followed
	double m_gravity;                          // where no world is followed [m/s^2]
	double m_weighing = 9.81;                  // the last that was not zero [m/s^2]
	std::unordered_map<const btCollisionObject*, btContactMaterial> m_materials;
};
