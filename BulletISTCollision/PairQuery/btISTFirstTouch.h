// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/PairQuery/btISTPairQuery.h"

/// Motion of a body during a step. Not installed.
struct btISTBodyMotion
{
	ist::Vec3 center;  ///< centre of mass [World]
	ist::Twist twist;  ///< of the centre of mass

	/// The motion if no contact holds the body: gravity and other forces of the step are included. `step` [s]. A body that the solver
	/// cannot move, or that is no rigid body, keeps its velocity.
	static btISTBodyMotion free(const btCollisionObject* object, double step);
	/// Returns the motion with another twist. Where that would turn the body by more than 45 degrees in the step, the angular velocity is
	/// the one by which Bullet turns it.
	btISTBodyMotion with(const ist::Twist& other, double step) const;
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
	btISTFirstTouch(const btISTPairQuery& query, const btISTBodyMotion& a, const btISTBodyMotion& b, double step)
		: m_query(query),
		  m_a(a),
		  m_b(b),
		  m_step(step)
	{}
	/// For a contact without overlap at its X_WA and X_AB. If the bodies touch within the step, gives the contact the sums of that touch
	/// and sets `ahead`; X_WA then makes the lever arms right for the faster body. Otherwise leaves the contact without overlap. Between
	/// the poses that it asks, a body moves by at most half of the thinner one's thickness, as long as kMostQueries suffice. Where they do
	/// not, it moves farther, and without a touch the result is false. No allocation.
	bool find(btISTContact& contact, ist::QueryWorkspace& workspace) const;

	/// For a contact with overlap that is too soft to stop the lighter body. If the motion takes the bodies far deeper into each other,
	/// gives the contact the sums of a pose on the way and sets `ahead` and X_WA, as `find` does. `later` is memory for the queries.
	void findFurther(btISTContact& contact, btISTContact& later, ist::QueryWorkspace& workspace) const;

	/// For a contact at the poses as the step began, with or without overlap. If the motion takes the bodies deeper into each other by more
	/// than kShallow, gives the contact the sums of the last pose on the way that is no deeper than `most`, a share of the thinner body's
	/// thickness. It sets `ahead` and X_WA as `find` does, and returns true. Otherwise the sums are those of another pose. Sets
	/// `touchMissed` where kMostQueries did not suffice and nothing was found. Contact whose stiffness was set is as deep as that lets it
	/// be: it counts as deeper where the motion makes it more than twice as deep.
	bool moveDeeper(btISTContact& contact, double most, ist::QueryWorkspace& workspace) const;

	/// Upper bound of the motion of any point of one body relative to the other until it touches the other in the step [m]. Zero if no
	/// point can. Bodies that roll on each other, as gears do, slip by much less where they meet than their rims move.
	static double travel(const btISTContact& contact, const btISTBodyMotion& a, const btISTBodyMotion& b, double step);

	/// Mean depth of the patch that is deepest on average [m].
	static double meanDepthOf(const btISTContact& contact);

	static constexpr int kMostQueries = 64;
	/// Motion in a step from which on a touch is looked for, as a share of the thickness of the thinner body.
	static constexpr double kWorthLooking = 0.02;
	/// Mean depth that counts as a touch, as such a share. A body that lies askew then touches with a side.
	static constexpr double kShallow = 0.05;

private:
	double travel(const btISTContact& contact) const { return travel(contact, m_a, m_b, m_step); }
	static double stride(double known, double left, int queries, double thickness, bool& missed);
	void turnLevers(double time, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact) const;
	/// Gives the contact the sums of the poses after this time [s].
	void moveTo(double time, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact, ist::QueryWorkspace& workspace) const;
	void approachDepth(double aimed, double before, double present, const ist::Pose& X_WA, const ist::Pose& X_WB, btISTContact& contact,
		ist::QueryWorkspace& workspace) const;

	const btISTPairQuery& m_query;
	const btISTBodyMotion &m_a, &m_b;
	double m_step;
};
