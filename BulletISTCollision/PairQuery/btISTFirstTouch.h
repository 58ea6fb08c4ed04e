// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/PairQuery/btISTPairQuery.h"

/// Motion of a body during a step if no contact holds it. Not installed.
struct btISTFreeMotion
{
	ist::Vec3 center;  ///< centre of mass [World]
	ist::Twist twist;  ///< of the centre of mass, gravity and other forces of the step included

	/// `step` [s]. A body that the solver cannot move, or that is no rigid body, keeps its velocity.
	static btISTFreeMotion of(const btCollisionObject* object, double step);
	/// Mass [kg]; infinite for a body that the solver cannot move, or that is no rigid body.
	static double massOf(const btCollisionObject& object);
	/// The smaller of the masses of the two bodies [kg].
	static double lighterMassOf(const btISTContact& contact);
	/// Pose after `time` [s] of what has the pose X_WS now and moves with the body.
	ist::Pose after(double time, const ist::Pose& X_WS) const;
	/// The same without the motion of the centre of mass: the lever arms of `after`, about the present centre.
	ist::Pose turned(double time, const ist::Pose& X_WS) const;
};

/// Finds the first touch of two bodies that would meet within a step, so that a solver can stop them there. Where bodies move by a
/// large part of the thinner one in a step, a query at the end of the step may find them far inside each other, or on the other side.
/// Not installed.
class btISTFirstTouch
{
public:
	btISTFirstTouch(const btISTPairQuery& query, const btISTFreeMotion& a, const btISTFreeMotion& b, double step)
		: m_query(query),
		  m_a(a),
		  m_b(b),
		  m_step(step)
	{}
	/// For a contact without overlap at its X_WA and X_AB. If the bodies touch within the step, gives the contact the sums of that touch
	/// and sets `ahead`; X_WA then makes the lever arms right for the faster body; with a closed form it has the rotation of that touch.
	/// Otherwise leaves the contact without overlap. Between the poses that it asks, a body moves by at most half of the thinner one's
	/// thickness, as long as kMostQueries suffice. Returns false where they did not. No allocation.
	bool find(btISTContact& contact, ist::QueryWorkspace& workspace) const;

	/// For a contact with overlap that is too soft to stop the lighter body. If the motion takes the bodies far deeper into each other,
	/// gives the contact the sums of a pose on the way and sets `ahead` and X_WA, as `find` does. `later` is memory for the queries.
	void findFurther(btISTContact& contact, btISTContact& later, ist::QueryWorkspace& workspace) const;

	static constexpr int kMostQueries = 64;
	/// Motion in a step from which on a touch is looked for, as a share of the thickness of the thinner body.
	static constexpr double kWorthLooking = 0.02;

private:
	bool moveFurther(btISTContact& contact, ist::QueryWorkspace& workspace) const;
	void turnLevers(double time, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact) const;
	double travel(const btISTContact& contact) const;
	void moveTo(double time, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact) const;
	void approachTouch(double apart, double touching, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact,
		ist::QueryWorkspace& workspace) const;

	const btISTPairQuery& m_query;
	const btISTFreeMotion &m_a, &m_b;
	double m_step;
};
