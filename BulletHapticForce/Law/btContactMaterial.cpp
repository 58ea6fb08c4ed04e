// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btContactMaterial.h"

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletDynamics/Dynamics/btDynamicsWorld.h"

#include <algorithm>
#include <cmath>

namespace
{
double combinedDissipation(const btContactMaterial& A, const btContactMaterial& B, double otherwise)
{
	if (A.dissipation >= 0 && B.dissipation >= 0)
	{
		const double sum = A.stiffness + B.stiffness;
		if (A.stiffness > 0 && B.stiffness > 0) return (B.stiffness * A.dissipation + A.stiffness * B.dissipation) / sum;
		return (A.dissipation + B.dissipation) / 2;
	}
	if (A.dissipation >= 0) return A.dissipation;
	return B.dissipation >= 0 ? B.dissipation : otherwise;
}
}  // namespace

std::optional<ist::Error> btContactMaterialTable::set(const btCollisionObject* body, const btContactMaterial& material)
{
	if (!body) return ist::Error{"a contact material needs a body"};
	if (!std::isfinite(material.stiffness) || material.stiffness < 0)
		return ist::Error{"the stiffness of a contact material must be a finite number of Pa/m, 0 or more (0: not set)"};
	if (material.stiffness > kStiffest)
		return ist::Error{"the stiffness of a contact material must be at most 1e15 Pa/m: no step of a game's length could hold it"};
	if (!std::isfinite(material.dissipation))
		return ist::Error{"the dissipation of a contact material must be a finite number of s/m (negative: not set)"};
	if (material.dissipation > kMostDissipation)
		return ist::Error{
			"the dissipation of a contact material must be at most 1e6 s/m: with it nothing leaves contact faster than 1 um/s"};
	if (!std::isfinite(material.fluidDensity) || material.fluidDensity < 0)
		return ist::Error{"the density of a fluid must be a finite number of kg/m^3, 0 or more (0: a solid)"};
	if (material.fluidDensity > kDensest)
		return ist::Error{"the density of a fluid must be at most 1e12 kg/m^3: no step of a game's length could hold its pressure"};
	if (material.fluidDensity > 0 && material.stiffness > 0)
		return ist::Error{"a fluid has no stiffness of its own: its pressure is its density times gravity times depth"};
	if (material.fluidDensity > 0 && (!body->getCollisionShape() || body->getCollisionShape()->getShapeType() != STATIC_PLANE_PROXYTYPE))
		return ist::Error{"only a static plane can be a fluid: give the body a btStaticPlaneShape"};
	m_materials[body] = material;
	return std::nullopt;
}

btContactMaterial btContactMaterialTable::find(const btCollisionObject* body) const
{
	const auto found = m_materials.find(body);
	return found == m_materials.end() ? btContactMaterial() : found->second;
}

void btContactMaterialTable::setGravity(double gravity)
{
	if (!(gravity >= 0) || !std::isfinite(gravity)) return;
	m_world = nullptr;
	m_gravity = gravity;
	if (gravity > 0) m_weighing = gravity;
}

void btContactMaterialTable::followGravity(const btDynamicsWorld* world)
{
	const double now = world ? double(world->getGravity().length()) : gravity();
	m_world = world;
	if (!std::isfinite(now)) return;
	m_gravity = now;
	if (now > 0) m_weighing = now;
}

double btContactMaterialTable::gravity() const
{
	const double ofWorld = m_world ? double(m_world->getGravity().length()) : m_gravity;
	return std::isfinite(ofWorld) ? ofWorld : m_gravity;
}

btISTPairConstants btContactMaterialTable::decide(
	const btISTContact& contact, const btCollisionObject* bodyA, const btCollisionObject* bodyB) const
{
	const double gravity = this->gravity();
	btISTPairConstants constants = btISTDefaultPairRule(gravity > 0 ? gravity : m_weighing).decide(contact, bodyA, bodyB);
	const btContactMaterial A = find(bodyA), B = find(bodyB);
	if (contact.halfSpace && B.fluidDensity > 0)
	{
		constants.k = B.fluidDensity * gravity;
		constants.weightA = constants.load = 0;
		constants.weightB = 1;
		constants.rule = btISTStiffnessRule::Fluid;
		constants.dissipation = std::max(B.dissipation, 0.0);
		return constants;
	}
	constants.freeRolling = A.dissipation < 0 && B.dissipation < 0;
	constants.dissipation = combinedDissipation(A, B, constants.dissipation);
	if (A.stiffness > 0 && B.stiffness > 0)
	{
		constants.k = A.stiffness * B.stiffness / (A.stiffness + B.stiffness);
		constants.weightA = B.stiffness / (A.stiffness + B.stiffness);
	}
	else if (A.stiffness > 0 || B.stiffness > 0)
	{
		constants.k = A.stiffness + B.stiffness;
		constants.weightA = A.stiffness > 0 ? 1 : 0;
	}
	if (A.stiffness > 0 || B.stiffness > 0)
	{
		constants.load = 0;
		constants.rule = btISTStiffnessRule::Given;
	}
	if (contact.halfSpace) constants.weightA = 0;
	constants.weightB = 1 - constants.weightA;
	return constants;
}
