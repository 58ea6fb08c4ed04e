// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/LeafClearance.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
// Shares of the thickness of the thinner body.
constexpr double kWorthLookingFurther = 0.1;  // motion in a step from which on a deeper place is looked for
constexpr double kStride = 0.5;               // largest motion between two queries
constexpr double kShallow = 0.05;             // mean depth that counts as a touch; a body that lies askew then touches with a side
constexpr int kMostHalvings = 10;

double deepest(const btISTContact& contact)
{
	double depth = 0;
	for (int i = 0; i < contact.patchCount; ++i) depth = std::max(depth, ist::meanDepth(contact.patches[i]));
	return depth;
}

ist::Pose poseOfB(const btISTContact& contact) { return contact.X_WA * contact.X_AB; }

/// Radius of a ball about the centre of rotation that contains the tree [m].
double reach(const ist::InnerSphereTree& tree, const ist::Pose& X_WS, const ist::Vec3& center)
{
	return ist::reachOf(tree) + distance(X_WS * tree.origin, center);
}
}  // namespace

btISTFreeMotion btISTFreeMotion::of(const btCollisionObject* object, double step)
{
	btISTFreeMotion motion;
	motion.center = toVec3(object->getWorldTransform().getOrigin());
	const btRigidBody* body = btRigidBody::upcast(object);
	if (!body) return motion;
	motion.twist = {toVec3(body->getLinearVelocity()), toVec3(body->getAngularVelocity())};
	if (!body->isStaticOrKinematicObject())
		motion.twist.linear += (step * double(body->getInvMass())) * toVec3(body->getTotalForce() * body->getLinearFactor());
	return motion;
}

ist::Pose btISTFreeMotion::after(double time, const ist::Pose& X_WS) const
{
	ist::Pose X = turned(time, X_WS);
	X.translation += time * twist.linear;
	return X;
}

ist::Pose btISTFreeMotion::turned(double time, const ist::Pose& X_WS) const
{
	const ist::Mat3 turn = ist::rotationMatrix(ist::quaternionFromRotationVector(time * twist.angular));
	return {turn * X_WS.rotation, center + turn * (X_WS.translation - center)};
}

double btISTFreeMotion::massOf(const btCollisionObject& object)
{
	const btRigidBody* body = btRigidBody::upcast(&object);
	const double inverse = body && !body->isStaticOrKinematicObject() ? double(body->getInvMass()) : 0;
	return inverse > 0 ? 1 / inverse : std::numeric_limits<double>::infinity();
}

double btISTFreeMotion::lighterMassOf(const btISTContact& contact) { return std::min(massOf(*contact.bodyA), massOf(*contact.bodyB)); }

/// Upper bound of the motion of any point of one body relative to the other in the step [m].
double btISTFirstTouch::travel(const btISTContact& contact) const
{
	double speed = norm(m_a.twist.linear - m_b.twist.linear);
	if (const double spin = norm(m_a.twist.angular); spin > 0) speed += spin * reach(*contact.treeA, contact.X_WA, m_a.center);
	if (const double spin = norm(m_b.twist.angular); spin > 0)
	{
		const ist::Pose X_WB = poseOfB(contact);
		// A closed form has no radius here; what of it can touch A lies within the reach of A.
		speed += spin * (contact.treeB ? reach(*contact.treeB, X_WB, m_b.center) : reach(*contact.treeA, contact.X_WA, m_b.center));
	}
	return speed * m_step;
}

void btISTFirstTouch::moveTo(double time, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact) const
{
	contact.X_AB = inverse(m_a.after(time, X_WA)) * m_b.after(time, X_WB);
}

/// Halves the time between a pose apart and one that touches until the touch is shallow.
void btISTFirstTouch::approachTouch(double apart, double touching, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact,
	ist::QueryWorkspace& workspace) const
{
	const double shallow = kShallow * contact.thickness();
	for (int i = 0; i < kMostHalvings && (contact.patchCount == 0 || ist::meanDepth(contact.total) > shallow); ++i)
	{
		const double middle = 0.5 * (apart + touching);
		moveTo(middle, X_WA, X_WB, contact);
		m_query.queryAt(contact, workspace);
		(contact.patchCount > 0 ? touching : apart) = middle;
	}
	if (contact.patchCount == 0)
	{
		moveTo(touching, X_WA, X_WB, contact);
		m_query.queryAt(contact, workspace);
	}
	turnLevers(touching, X_WA, X_WB, contact);
}

/// Sets `ahead` and the pose that gives the lever arms.
void btISTFirstTouch::turnLevers(double time, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact) const
{
	contact.ahead = time;
	const bool fasterB = squaredNorm(m_b.twist.linear) > squaredNorm(m_a.twist.linear);
	// With the lever arms of the turned body, some of two tumbling trees were not held by a thin plate. A ball that rolls needs them.
	const double turning = contact.treeB ? 0 : time;
	contact.X_WA = fasterB ? m_b.turned(turning, X_WB) * inverse(contact.X_AB) : m_a.turned(turning, X_WA);
}

/// Moves the contact to the first pose at which it is far deeper than now, but still shallow. Returns false where there is none.
bool btISTFirstTouch::moveFurther(btISTContact& contact, ist::QueryWorkspace& workspace) const
{
	const double stride = m_step * kStride * contact.thickness() / travel(contact);
	const double aimed = std::max(kShallow * contact.thickness(), 2 * deepest(contact));
	const ist::Pose X_WA = contact.X_WA, X_WB = poseOfB(contact);
	double before = 0, time = 0;
	for (int i = 0; i < kMostQueries && !(deepest(contact) > aimed); ++i)
	{
		if (time >= m_step || contact.patchCount == 0) return false;
		before = time;
		time = std::min(time + stride, m_step);
		moveTo(time, X_WA, X_WB, contact);
		m_query.queryAt(contact, workspace);
	}
	for (int i = 0; i < kMostHalvings && deepest(contact) > aimed; ++i)
	{
		time = 0.5 * (before + time);
		moveTo(time, X_WA, X_WB, contact);
		m_query.queryAt(contact, workspace);
	}
	turnLevers(time, X_WA, X_WB, contact);
	return contact.patchCount > 0;
}

void btISTFirstTouch::findFurther(btISTContact& contact, btISTContact& later, ist::QueryWorkspace& workspace) const
{
	const double way = travel(contact), k = contact.grown > 0 ? contact.grown : contact.constants.k;
	const bool isTooSoft = k * norm(contact.total.areaVector) * m_step * m_step < btISTFreeMotion::lighterMassOf(contact);
	if (!isTooSoft || !(way > kWorthLookingFurther * contact.thickness()) || !std::isfinite(way)) return;
	later = contact;
	if (moveFurther(later, workspace))
	{
		btISTPairQuery::copyAnswer(later, contact);
		contact.X_AB = later.X_AB;
		contact.X_WA = later.X_WA;
	}
	later.treeA.reset();
	later.treeB.reset();
	later.memory.reset();
}

bool btISTFirstTouch::find(btISTContact& contact, ist::QueryWorkspace& workspace) const
{
	const double way = travel(contact), thickness = contact.thickness();
	if (!(way > kWorthLooking * thickness) || !std::isfinite(way)) return true;
	const ist::Pose X_WA = contact.X_WA, X_AB = contact.X_AB, X_WB = poseOfB(contact);
	const ist::AdaptiveLevel accuracy = contact.accuracy;
	double time = 0;
	int queries = 0;
	while (time < m_step && queries < kMostQueries)
	{
		const double known = m_query.clearanceAt(contact), before = time;
		if (known >= way * (1 - time / m_step)) break;
		const double clear = std::max(known, kStride * thickness);
		time = std::min(time + m_step * clear / way, m_step);
		moveTo(time, X_WA, X_WB, contact);
		m_query.queryAt(contact, workspace);
		++queries;
		if (contact.patchCount == 0) continue;
		approachTouch(before, time, X_WA, X_WB, contact, workspace);
		return true;
	}
	contact.X_AB = X_AB;
	contact.accuracy = accuracy;
	return queries < kMostQueries || time >= m_step;
}
