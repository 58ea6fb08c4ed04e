// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/LeafClearance.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "LinearMath/btTransformUtil.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
// Shares of the thickness of the thinner body.
constexpr double kWorthLookingFurther = 0.1;  // motion in a step from which on a deeper place is looked for
constexpr double kStride = 0.5;               // largest motion between two queries
constexpr double kLeastOfAimed = 0.3;         // of an aimed depth: the area of a slighter touch says little
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

btISTBodyMotion btISTBodyMotion::free(const btCollisionObject* object, double step)
{
	btISTBodyMotion motion;
	motion.center = toVec3(object->getWorldTransform().getOrigin());
	const btRigidBody* body = btRigidBody::upcast(object);
	if (!body) return motion;
	motion.twist = {toVec3(body->getLinearVelocity()), toVec3(body->getAngularVelocity())};
	if (!body->isStaticOrKinematicObject())
		motion.twist.linear += (step * double(body->getInvMass())) * toVec3(body->getTotalForce() * body->getLinearFactor());
	return motion.with(motion.twist, step);
}

btISTBodyMotion btISTBodyMotion::with(const ist::Twist& other, double step) const
{
	const double angle = step * norm(other.angular), most = double(ANGULAR_MOTION_THRESHOLD);
	return {center, {other.linear, angle > most ? most / angle * other.angular : other.angular}};
}

ist::Pose btISTBodyMotion::after(double time, const ist::Pose& X_WS) const
{
	ist::Pose X = turned(time, X_WS);
	X.translation += time * twist.linear;
	return X;
}

ist::Pose btISTBodyMotion::turned(double time, const ist::Pose& X_WS) const
{
	const ist::Mat3 turn = ist::rotationMatrix(ist::quaternionFromRotationVector(time * twist.angular));
	return {turn * X_WS.rotation, center + turn * (X_WS.translation - center)};
}

double btISTBodyMotion::massOf(const btCollisionObject& object)
{
	const btRigidBody* body = btRigidBody::upcast(&object);
	const double inverse = body && !body->isStaticOrKinematicObject() ? double(body->getInvMass()) : 0;
	return inverse > 0 ? 1 / inverse : std::numeric_limits<double>::infinity();
}

double btISTBodyMotion::lighterMassOf(const btISTContact& contact) { return std::min(massOf(*contact.bodyA), massOf(*contact.bodyB)); }

double btISTFirstTouch::travel(const btISTContact& contact, const btISTBodyMotion& a, const btISTBodyMotion& b, double step)
{
	double speed = norm(a.twist.linear - b.twist.linear);
	if (const double spin = norm(a.twist.angular); spin > 0) speed += spin * reach(*contact.treeA, contact.X_WA, a.center);
	if (const double spin = norm(b.twist.angular); spin > 0)
	{
		const ist::Pose X_WB = poseOfB(contact);
		// A closed form has no radius here; what of it can touch A lies within the reach of A.
		speed += spin * (contact.treeB ? reach(*contact.treeB, X_WB, b.center) : reach(*contact.treeA, contact.X_WA, b.center));
	}
	return speed * step;
}

void btISTFirstTouch::moveTo(
	double time, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact, ist::QueryWorkspace& workspace) const
{
	contact.X_AB = inverse(m_a.after(time, X_WA)) * m_b.after(time, X_WB);
	m_query.queryAt(contact, workspace);
}

/// Halves the time between a pose that is less deep than `aimed` [m] and the present one, until that is neither deeper nor much less deep.
void btISTFirstTouch::approachDepth(double aimed, double before, double present, const ist::Pose& X_WA, const ist::Pose& X_WB,
	btISTContact& contact, ist::QueryWorkspace& workspace) const
{
	double time = present;
	for (int i = 0; i < kMostHalvings; ++i)
	{
		const double depth = deepest(contact);
		if (depth > aimed) present = time;
		else if (i > 0 && depth < kLeastOfAimed * aimed) before = time;
		else break;
		time = 0.5 * (before + present);
		moveTo(time, X_WA, X_WB, contact, workspace);
	}
	if (contact.patchCount == 0)
	{
		time = present;
		moveTo(time, X_WA, X_WB, contact, workspace);
	}
	turnLevers(time, X_WA, X_WB, contact);
}

/// Sets `ahead` and the pose that gives the lever arms.
void btISTFirstTouch::turnLevers(double time, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact) const
{
	contact.ahead = time;
	const bool fasterB = squaredNorm(m_b.twist.linear) > squaredNorm(m_a.twist.linear);
	// A body that cannot move gives the normal as it is in World. Two that move have the lever arms of the middle of the way: those are
	// right to second order.
	const bool bothMove = std::isfinite(btISTBodyMotion::massOf(*contact.bodyA)) && std::isfinite(btISTBodyMotion::massOf(*contact.bodyB));
	const double turning = bothMove ? 0.5 * time : time;
	contact.X_WA = fasterB ? m_b.turned(turning, X_WB) * inverse(contact.X_AB) : m_a.turned(turning, X_WA);
}

bool btISTFirstTouch::moveDeeper(btISTContact& contact, double most, ist::QueryWorkspace& workspace) const
{
	const double way = travel(contact), thickness = contact.thickness();
	const double far = std::max(kShallow * thickness, 2 * deepest(contact)), deep = std::max(most * thickness, far);
	const ist::Pose X_WA = contact.X_WA, X_WB = poseOfB(contact);
	double before = 0, time = 0;
	bool found = false;
	int queries = 0;
	while (time < m_step && queries < kMostQueries && !(deepest(contact) > deep))
	{
		const bool apart = contact.patchCount == 0;
		const double known = apart ? m_query.clearanceAt(contact) : 0;
		if ((apart && found) || known >= way * (1 - time / m_step)) break;
		before = time;
		time = std::min(time + m_step * std::max(known, kStride * thickness) / way, m_step);
		moveTo(time, X_WA, X_WB, contact, workspace);
		found = found || deepest(contact) > far;
		++queries;
	}
	contact.touchMissed = contact.touchMissed || (queries == kMostQueries && time < m_step);
	if (!found) return false;
	approachDepth(deep, before, time, X_WA, X_WB, contact, workspace);
	return contact.patchCount > 0;
}

void btISTFirstTouch::findFurther(btISTContact& contact, btISTContact& later, ist::QueryWorkspace& workspace) const
{
	const double way = travel(contact), k = contact.grown > 0 ? contact.grown : contact.constants.k;
	const bool isTooSoft = k * norm(contact.total.areaVector) * m_step * m_step < btISTBodyMotion::lighterMassOf(contact);
	if (!isTooSoft || !(way > kWorthLookingFurther * contact.thickness()) || !std::isfinite(way)) return;
	later = contact;
	if (moveDeeper(later, kShallow, workspace))
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
		moveTo(time, X_WA, X_WB, contact, workspace);
		++queries;
		if (contact.patchCount == 0) continue;
		approachDepth(kShallow * thickness, before, time, X_WA, X_WB, contact, workspace);
		return true;
	}
	contact.X_AB = X_AB;
	contact.accuracy = accuracy;
	return queries < kMostQueries || time >= m_step;
}
