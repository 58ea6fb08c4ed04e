// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Query/LeafClearance.h"
#include "BulletISTCollision/Core/Query/PlanarBody.h"
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

ist::Pose poseOfB(const btISTContact& contact) { return contact.X_WA * contact.X_AB; }

/// Radius of a ball about the centre of rotation that contains the surface [m]; the leaves of a body without one.
double reach(const ist::InnerSphereTree& tree, const ist::Pose& X_WS, const ist::Vec3& center)
{
	if (tree.surface.empty()) return ist::reachOf(tree) + distance(X_WS * tree.origin, center);
	const ist::BodyBall ball = ist::ballAround(tree.surface.surface, {X_WS.rotation, X_WS * tree.origin});
	return ball.radius + distance(ball.center, center);
}

/// A ball around all points of both; of negative radius if there are none.
ist::BodyBall intersection(const ist::BodyBall& a, const ist::BodyBall& b)
{
	const double d = distance(a.center, b.center);
	if (d > a.radius + b.radius) return {a.center, -1};
	// Distance from the centre of `a` to the plane of the circle in which the balls meet.
	const double x = d > 0 ? 0.5 * (d + (a.radius - b.radius) * (a.radius + b.radius) / d) : 0;
	if (!(x > 0) || !(x < d)) return a.radius < b.radius ? a : b;
	return {a.center + x / d * (b.center - a.center), std::sqrt(std::max(a.radius * a.radius - x * x, 0.0))};
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
	if (!(angle > most) || !std::isfinite(angle)) return {center, other};
	// btTransformUtil::integrateTransform limits the angle, but not the axis that it multiplies by the sine of its half.
	const double turn = 2 * std::atan(angle / most * std::tan(0.5 * most));
	return {center, {other.linear, turn / angle * other.angular}};
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

double btISTFirstTouch::meanDepthOf(const btISTContact& contact)
{
	double depth = 0;
	for (int i = 0; i < contact.patchCount; ++i) depth = std::max(depth, ist::meanDepth(contact.patches[i]));
	return depth;
}

double btISTFirstTouch::travel(const btISTContact& contact, const btISTBodyMotion& a, const btISTBodyMotion& b, double step)
{
	const ist::Vec3 relative = a.twist.linear - b.twist.linear;
	const double spinA = norm(a.twist.angular), spinB = norm(b.twist.angular), way = step * norm(relative);
	if (!(spinA + spinB > 0)) return way;
	const double reachA = reach(*contact.treeA, contact.X_WA, a.center);
	// A closed form has no radius here; what of it can touch A lies within the reach of A.
	if (!contact.treeB) return way + step * (spinA * reachA + spinB * reach(*contact.treeA, contact.X_WA, b.center));
	const double reachB = reach(*contact.treeB, poseOfB(contact), b.center);
	const double everywhere = way + step * (spinA * reachA + spinB * reachB);
	// Points that touch lie in both balls then. What moves with the centre of A and is in the ball of B at some time is in the wider one
	// now.
	const ist::BodyBall common = intersection({{}, reachA}, {b.center - a.center, reachB + way});
	if (common.radius < 0) return 0;
	// On its way there a point of A turns about the centre of A, and the centre of B moves from it.
	const double radius = common.radius + step * spinA * (norm(common.center) + common.radius);
	const ist::Vec3 slip = relative + cross(a.twist.angular, common.center) - cross(b.twist.angular, common.center + a.center - b.center);
	return std::min(everywhere, step * (norm(slip) + spinB * way + norm(a.twist.angular - b.twist.angular) * radius));
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
		const double depth = meanDepthOf(contact);
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

/// Motion to the next pose [m]. What is left of the way is taken in as many equal strides as there are queries left, if shorter ones do not
/// suffice: those may pass a thin place.
double btISTFirstTouch::stride(double known, double left, int queries, double thickness, bool& missed)
{
	const double sound = std::max(known, kStride * thickness), longest = left / std::max(kMostQueries - queries, 1);
	missed = missed || longest > sound;
	return std::max(sound, longest);
}

bool btISTFirstTouch::moveDeeper(btISTContact& contact, double most, ist::QueryWorkspace& workspace) const
{
	const double way = travel(contact), thickness = contact.thickness();
	const double present = meanDepthOf(contact), touch = kShallow * thickness;
	const double far = contact.constants.load > 0 ? present + touch : std::max(touch, 2 * present), deep = std::max(most * thickness, far);
	const ist::Pose X_WA = contact.X_WA, X_WB = poseOfB(contact);
	double before = 0, time = 0, deepest = 0, beforeDeepest = 0, timeDeepest = 0;
	bool missed = false;
	for (int queries = 0; time < m_step && !(meanDepthOf(contact) > deep); ++queries)
	{
		const bool apart = contact.patchCount == 0;
		const double known = apart ? m_query.clearanceAt(contact) : 0, left = way * (1 - time / m_step);
		if ((apart && deepest > far) || known >= left) break;
		before = time;
		time = std::min(time + m_step * stride(known, left, queries, thickness, missed) / way, m_step);
		moveTo(time, X_WA, X_WB, contact, workspace);
		const double depth = meanDepthOf(contact);
		if (depth > deepest) deepest = depth, beforeDeepest = before, timeDeepest = time;
	}
	const bool found = deepest > far;
	contact.touchMissed = contact.touchMissed || (missed && !found);
	if (!found) return false;
	// What has passed a thin place is apart again, or nearly so.
	if (meanDepthOf(contact) < deepest)
	{
		before = beforeDeepest;
		time = timeDeepest;
		moveTo(time, X_WA, X_WB, contact, workspace);
	}
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
	bool missed = false;
	for (int queries = 0; time < m_step; ++queries)
	{
		const double known = m_query.clearanceAt(contact), left = way * (1 - time / m_step), before = time;
		if (known >= left) break;
		time = std::min(time + m_step * stride(known, left, queries, thickness, missed) / way, m_step);
		moveTo(time, X_WA, X_WB, contact, workspace);
		if (contact.patchCount == 0) continue;
		approachDepth(kShallow * thickness, before, time, X_WA, X_WB, contact, workspace);
		return true;
	}
	contact.X_AB = X_AB;
	contact.accuracy = accuracy;
	return !missed;
}
