// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTDeflectedPairs.h"

#include "BulletISTCollision/Core/Force/RelativeMotion.h"
#include "BulletISTCollision/Dispatch/btISTContext.h"
#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"

#include <algorithm>
#include <cmath>

namespace
{
/// Depth up to which a pose on the way gives the normal and the area of the contact, as a share of the thinner body's thickness. A pair
/// whose touch is known is asked for as late a pose as this allows: what turns a body after the touch brings other places together.
constexpr double kSound = 0.4;
constexpr double kCorner = 3;  // largest depth of a corner over its mean depth
/// Error of a foretold force, as a share of it, up to which a solution stands.
constexpr double kForetold = 0.3;
/// Depth up to which a foretold solution stands where the stiffness follows the load, as such a share.
constexpr double kTolerated = 0.07;

/// Whether the sums of the contact foretell those of the pose of `later` to first order, as the solver has supposed. Where its stiffness
/// was set, the solution then is what was asked for, however deep; else it is good enough where it is not far beyond a touch.
bool isForetold(const btISTContact& contact, const btISTContact& later)
{
	if (contact.patchCount == 0) return false;
	if (contact.constants.load > 0 && btISTFirstTouch::meanDepthOf(later) > kTolerated * contact.thickness()) return false;
	ist::OverlapIntegrals total = contact.total;
	ist::moveB(total, ist::motionOfB(contact.X_AB, later.X_AB, contact.treeA->origin));
	const ist::PressurePair weights{1, contact.constants.weightA, contact.constants.weightB};
	const ist::Vec3 force = ist::pressureWrench(later.total, weights).force;
	return distance(ist::pressureWrench(total, weights).force, force) < kForetold * norm(force);
}
}  // namespace

/// The motion, and what it has more than the free one.
struct btISTDeflectedPairs::Deflected
{
	btISTBodyMotion motion, change;

	Deflected(const btCollisionObject* body, const ist::Twist* solved, double step)
		: motion(btISTBodyMotion::free(body, step)),
		  change(motion)
	{
		const ist::Twist free = motion.twist;
		if (solved) motion = motion.with(*solved, step);
		change.twist = motion.twist - free;
	}
};

/// How a pair is asked.
struct btISTDeflectedPairs::Query
{
	btISTShapeField field;
	btISTPairQuery query;

	Query(const btISTContact& contact, const btISTContext& context)
		: field(contact.treeB ? btISTShapeField() : btISTShapeField(contact.shapeB)),
		  query(field, context.rules, true, context.store.sumsDamping())
	{}
};

/// Looks along the motion for a pose in which the two bodies are deeper by more than a touch, and asks the context's spare contact there. A
/// contact that presses already is asked for a depth of up to `mostOfKnown`, a share of the thickness.
bool btISTDeflectedPairs::look(const btISTContact& contact, const Deflected& a, const Deflected& b, double mostOfKnown, double step)
{
	btISTContact& later = m_context.later;
	later.touchMissed = contact.touchMissed;
	// No place comes deeper than the deepest one by more than the bodies move, and at most that one is three mean depths deep, at a corner.
	const double least = std::max(btISTFirstTouch::kWorthLooking * contact.thickness(),
		btISTFirstTouch::kShallow * contact.thickness() - (kCorner - 1) * btISTFirstTouch::meanDepthOf(contact));
	const double way = btISTFirstTouch::travel(contact, a.motion, b.motion, step);
	if (!(way > least) || !std::isfinite(way)) return false;
	const bool isKnown = contact.patchCount > 0;
	if (!isKnown && !(btISTFirstTouch::travel(contact, a.change, b.change, step) > least)) return false;

	const Query pair(contact, m_context);
	later = contact;
	later.X_WA = contact.startX_WA;
	later.X_AB = contact.startX_AB;
	later.ahead = 0;
	if (contact.ahead > 0) pair.query.queryAt(later, m_context.workspace);
	const double most = isKnown ? mostOfKnown : btISTFirstTouch::kShallow;
	const btISTFirstTouch touch(pair.query, a.motion, b.motion, step);
	return touch.moveDeeper(later, most, m_context.workspace);
}

void btISTDeflectedPairs::forgetLook()
{
	m_context.later.treeA.reset();
	m_context.later.treeB.reset();
	m_context.later.memory.reset();
}

bool btISTDeflectedPairs::findDeeper(btISTContact& contact, const ist::Twist* motionA, const ist::Twist* motionB, double step)
{
	const Deflected a(contact.bodyA, motionA, step), b(contact.bodyB, motionB, step);
	const bool isNews = look(contact, a, b, kSound, step) && !isForetold(contact, m_context.later);
	btISTContact& later = m_context.later;
	if (later.touchMissed && !contact.touchMissed) m_context.store.countMissedTouch();
	contact.touchMissed = later.touchMissed;
	if (isNews)
	{
		later.constants = m_context.rule->decide(later, later.bodyA, later.bodyB);
		const Query pair(contact, m_context);
		if (pair.query.lacksDamping(later)) pair.query.queryAt(later, m_context.workspace);
		btISTPairQuery::copyAnswer(later, contact);
		contact.X_AB = later.X_AB;
		contact.X_WA = later.X_WA;
		contact.constants = later.constants;
		contact.deflected = true;
		contact.supposedA = a.change.twist;
		contact.supposedB = b.change.twist;
		btISTPairQuery::judge(contact);
	}
	forgetLook();
	return isNews;
}

double btISTDeflectedPairs::timeUntilDeep(const btISTContact& contact, const ist::Twist* motionA, const ist::Twist* motionB, double step)
{
	const Deflected a(contact.bodyA, motionA, step), b(contact.bodyB, motionB, step);
	// Whether that is foretold shows where it is deep, not where it begins to be.
	const bool isDeep = look(contact, a, b, kSound, step) && !isForetold(contact, m_context.later) &&
		look(contact, a, b, btISTFirstTouch::kShallow, step);
	const double time = isDeep ? m_context.later.ahead : step;
	forgetLook();
	return time;
}
