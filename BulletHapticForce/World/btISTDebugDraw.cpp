// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btISTDebugDraw.h"

#include "BulletHapticForce/Law/btContactLaw.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "LinearMath/btIDebugDraw.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace
{
const btVector3 kGrey(btScalar(0.5), btScalar(0.5), btScalar(0.5)), kBlue(btScalar(0.2), btScalar(0.4), 1);
constexpr int kRingParts = 12;
constexpr double kPi = 3.14159265358979323846;

/// Green at 0, yellow in the middle, red from 1 on.
btVector3 warning(double share)
{
	const double s = std::clamp(share, 0.0, 1.0);
	return btVector3(btScalar(std::min(1.0, 2 * s)), btScalar(std::min(1.0, 2 - 2 * s)), 0);
}

bool moves(const btCollisionObject& object) { return !object.isStaticOrKinematicObject(); }

void drawRing(const btContactPatch& patch, const btVector3& colour, btIDebugDraw& drawer)
{
	ist::Vec3 u, v;
	ist::completeFrame(patch.normal, u, v);
	const auto at = [&](int i) {
		const double angle = 2 * kPi * i / kRingParts;
		return toBullet(patch.point + patch.frictionRadius * (std::cos(angle) * u + std::sin(angle) * v));
	};
	for (int i = 0; i < kRingParts; ++i) drawer.drawLine(at(i), at(i + 1), colour);
}

void drawContact(const btISTContact& contact, const btISTDebugDraw& what, btIDebugDraw& drawer)
{
	const bool movesA = moves(*contact.bodyA), movesB = moves(*contact.bodyB);
	const btVector3 colour = warning(contact.depth / (btISTContact::kDeep * contact.thickness()));
	btContactPatch patch;
	for (int i = 0; i < contact.patchCount; ++i)
	{
		if (!evaluateContactPatch(contact, i, patch)) continue;
		const btVector3 point = toBullet(patch.point);
		if (what.pairs)
		{
			if (movesA) drawer.drawLine(contact.bodyA->getWorldTransform().getOrigin(), point, colour);
			if (movesB) drawer.drawLine(contact.bodyB->getWorldTransform().getOrigin(), point, colour);
		}
		if (!what.patches) continue;
		drawRing(patch, colour, drawer);
		const ist::Vec3 force = movesA ? patch.wrench.force : -patch.wrench.force;
		drawer.drawLine(point, toBullet(patch.point + what.metresPerNewton * force), kBlue);
		if (!what.text) continue;
		char text[48];
		std::snprintf(text, sizeof text, "%.3g N, %.3g mm", norm(force), 1e3 * ist::meanDepth(contact.patches[i]));
		drawer.draw3dText(point, text);
	}
}

void drawStock(const btPersistentManifold& manifold, btIDebugDraw& drawer)
{
	for (int i = 0; i < manifold.getNumContacts(); ++i)
	{
		const btManifoldPoint& point = manifold.getContactPoint(i);
		const btVector3 from = point.getPositionWorldOnB();
		drawer.drawLine(from, from + point.m_normalWorldOnB * btScalar(0.02), kGrey);
	}
}

const ist::BallTree* ballsOf(const ist::InnerSphereTree& tree, int balls)
{
	if (balls < 0) return &tree.inner;
	if (balls == 0) return &tree.law;
	return std::size_t(balls) <= tree.levels.size() ? &tree.levels[std::size_t(balls - 1)] : nullptr;
}

void drawBalls(
	const btISTRegistry& registry, const btCollisionShape& shape, const ist::Pose& X_WS, const btISTDebugDraw& what, btIDebugDraw& drawer)
{
	const auto tree = registry.find(&shape);
	if (!tree && shape.isCompound())
	{
		const auto& compound = static_cast<const btCompoundShape&>(shape);
		for (int i = 0; i < compound.getNumChildShapes(); ++i)
			drawBalls(registry, *compound.getChildShape(i), X_WS * toRigidPose(compound.getChildTransform(i)), what, drawer);
		return;
	}
	const ist::BallTree* balls = tree ? ballsOf(*tree, what.balls) : nullptr;
	if (!balls || what.mostBalls < 1) return;
	const std::size_t most = std::size_t(what.mostBalls), stride = (balls->ballCount() + most - 1) / most;
	std::size_t count = 0;
	for (std::size_t slot = 0; slot < balls->slotCount(); ++slot)
	{
		const ist::MomentEllipsoid ball = balls->ball(slot);
		if (!(ball.density > 0) || count++ % stride) continue;
		drawer.drawSphere(toBullet(X_WS * (tree->origin + ball.center())), btScalar(ball.meanRadius()), kBlue);
	}
}
}  // namespace

void btISTWorld::debugDraw(btIDebugDraw& drawer, const btISTDebugDraw& what)
{
	if (drawer.getDebugMode() == btIDebugDraw::DBG_NoDebug) return;
	for (const btISTContact* contact : contacts().contacts())
		if (contact->patchCount > 0 && contact->ahead == 0) drawContact(*contact, what, drawer);
	const btCollisionObjectArray& objects = m_world->getCollisionObjectArray();
	for (int i = 0; what.balls >= -1 && i < objects.size(); ++i)
		drawBalls(m_registration.registry(), *objects[i]->getCollisionShape(), toRigidPose(objects[i]->getWorldTransform()), what, drawer);
	btDispatcher& dispatcher = *m_world->getDispatcher();
	for (int i = 0; what.stock && i < dispatcher.getNumManifolds(); ++i)
	{
		const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
		if (!contacts().find(&manifold)) drawStock(manifold, drawer);
	}
}
