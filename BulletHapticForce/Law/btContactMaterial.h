// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Base/Result.h"

#include <cmath>
#include <optional>
#include <unordered_map>

class btDynamicsWorld;

/// The material of a body in the pressure field law. Friction is set in Bullet, with btCollisionObject::setFriction.
struct btContactMaterial
{
	double stiffness = 0;     ///< k_X [Pa/m], pressure per depth. 0: not set
	double dissipation = -1;  ///< Hunt-Crossley dissipation [s/m]; bodies separate at most at its inverse [m/s]. Negative: not set
	double fluidDensity = 0;  ///< density [kg/m^3] of a fluid that fills a half-space; 0: a solid

	/// A fluid, for a static plane (btStaticPlaneShape) whose normal points against gravity. Its pressure is hydrostatic: density times
	/// gravity times depth, whatever the material of the floating body. It has no drag unless it is given a dissipation. Bullet's
	/// friction of the plane still acts, so call setFriction(0) on it. Floating bodies need trees. Waves and added mass are not modelled.
	static btContactMaterial fluid(double density) { return {0, -1, density}; }
	/// Elastic foundation: modulus [Pa] divided by the depth [m] of the layer that yields.
	static btContactMaterial fromModulus(double modulus, double foundationDepth) { return {modulus / foundationDepth, -1}; }
};

/// Decides the constants of a pair from the materials of its bodies:
/// (a) Against a half-space, its field has all the weight, whatever the materials. Against a fluid, k is density times gravity, and the
/// dissipation is that of the fluid, or zero.
/// (b) Both stiffnesses are set: they act in series, 1/k = 1/k_A + 1/k_B and w_A = k_B/(k_A + k_B). The softer body's field has the
/// larger weight.
/// (c) One stiffness is set: k is that one, and its body's field has all the weight.
/// (d) No stiffness is set: btISTDefaultPairRule decides. The solver raises k for the weight of all bodies that are connected with the
/// two through contacts. It lowers k where the step could not bear it (carryLoad in btContactLaw.h).
///
/// The dissipation is d = (k_B d_A + k_A d_B)/(k_A + k_B) when both stiffnesses and both dissipations are set. Otherwise it is the mean
/// of the dissipations that are set, or that of (d) when none is set. Only the thread of the world may use the table.
class btContactMaterialTable : public btISTPairRule
{
public:
	// Bodies of 1 cm and more rest with these limits, all three at once, in steps of up to 1/60 s. A little beyond any of them, bodies
	// are flung away or fall through.
	static constexpr double kStiffest = 1e15;        ///< [Pa/m]: steel with a yielding layer of 0.2 mm
	static constexpr double kMostDissipation = 1e6;  ///< [s/m]
	static constexpr double kDensest = 1e12;  ///< density of a fluid [kg/m^3]: in a gravity of 1000 m/s^2 its pressure rises by kStiffest

	/// `gravity` is passed to setGravity.
	explicit btContactMaterialTable(double gravity = 9.81) : m_gravity(9.81) { setGravity(gravity); }

	/// Sets the material of `body`. Refused, with the reason: values that are not finite or beyond the limits above, a negative stiffness
	/// or density, a fluid with a stiffness, and a fluid on any other shape than a plane. Call `remove` before the body is deleted,
	/// because its address may be given to a new body.
	std::optional<ist::Error> set(const btCollisionObject* body, const btContactMaterial& material);
	void remove(const btCollisionObject* body) { m_materials.erase(body); }
	/// Material from `set`, or one with nothing set.
	btContactMaterial find(const btCollisionObject* body) const;
	/// Sets the magnitude of gravity [m/s^2]. It is used for fluids and, in (d), for bodies that have no gravity of their own. A value
	/// that is negative or not finite is ignored. For (d) a gravity of zero keeps the last positive one, so that bodies without weight
	/// still have contact.
	void setGravity(double gravity);
	/// Uses the gravity that `world` has whenever a pair is decided. The world must stay alive until the next call of this method or of
	/// setGravity. With null, the last gravity of the former world stays.
	void followGravity(const btDynamicsWorld* world);
	/// Gravity that applies now [m/s^2].
	double gravity() const;

	btISTPairConstants decide(const btISTContact& contact, const btCollisionObject* bodyA, const btCollisionObject* bodyB) const override;

private:
	const btDynamicsWorld* m_world = nullptr;  // the world whose gravity is used; null: m_gravity is
	double m_gravity;                          // gravity without a world [m/s^2]
	double m_weighing = 9.81;                  // last positive gravity [m/s^2], for (d)
	std::unordered_map<const btCollisionObject*, btContactMaterial> m_materials;
};
