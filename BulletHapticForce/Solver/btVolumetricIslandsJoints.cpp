// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btSolverBodyMotion.h"
#include "BulletHapticForce/Solver/btVolumetricIslands.h"

#include <algorithm>
#include <cmath>
#include <iterator>

// The joints of the islands.

using namespace btSolverBodyMotion;

namespace
{
/// Impulse on a body by a unit impulse of a joint's row, about the body's centre of mass. It is the derivative of the row's velocity, too.
ist::Wrench pushOf(const btSolverConstraint& row, int side)
{
	return side == 0 ? ist::Wrench{toVec3(row.m_contactNormal1), toVec3(row.m_relpos1CrossNormal)}
					 : ist::Wrench{toVec3(row.m_contactNormal2), toVec3(row.m_relpos2CrossNormal)};
}

/// Change of the body's twist by all impulses so far.
ist::Twist changeOf(const btSolverBody& body) { return {toVec3(body.getDeltaLinearVelocity()), toVec3(body.getDeltaAngularVelocity())}; }

bool isFinite(const btSolverConstraint& row)
{
	for (int side = 0; side < 2; ++side)
		if (!ist::isFinite(pushOf(row, side).force) || !ist::isFinite(pushOf(row, side).torque)) return false;
	return std::isfinite(row.m_rhs) && std::isfinite(row.m_cfm) && std::isfinite(row.m_jacDiagABInv) &&
		row.m_lowerLimit <= row.m_upperLimit;
}

/// Calls `act(side, body)` for the bodies of a row that can move.
template <class Act> void forEachSide(const btSolverConstraint& row, const btSolverBody* bodies, const Act& act)
{
	if (canMove(bodies[row.m_solverBodyIdA])) act(0, row.m_solverBodyIdA);
	if (canMove(bodies[row.m_solverBodyIdB])) act(1, row.m_solverBodyIdB);
}
}  // namespace

void btVolumetricIslands::addJoints(btConstraintArray& rows, const btSolverBody* bodies)
{
	for (int i = 0; i < rows.size();)
	{
		Joint joint;
		joint.rows = &rows[i];
		joint.bodyA = rows[i].m_solverBodyIdA;
		joint.bodyB = rows[i].m_solverBodyIdB;
		joint.finite = isFinite(bodies[joint.bodyA]) && isFinite(bodies[joint.bodyB]);
		for (; i < rows.size() && rows[i].m_originalContactPoint == joint.rows->m_originalContactPoint; ++i, ++joint.count)
			joint.finite = joint.finite && ::isFinite(rows[i]);
		m_joints.push_back(joint);
	}
}

int btVolumetricIslands::movableBody(const Joint& joint, const btSolverBody* bodies)
{
	return canMove(bodies[joint.bodyA]) ? joint.bodyA : joint.bodyB;
}

/// Finds with what force the motor at a body can press. Only rows of motors have a limited impulse both ways.
void btVolumetricIslands::findMotors(const btSolverBody* bodies)
{
	constexpr double kUnlimited = 1e18;
	m_motors.assign(m_parent.size(), 0.0);
	for (const Joint& joint : m_joints)
		for (int i = 0; i < joint.count && joint.finite; ++i)
		{
			const btSolverConstraint& row = joint.rows[i];
			const double impulse = std::max(-double(row.m_lowerLimit), double(row.m_upperLimit)), inertia = double(row.m_jacDiagABInv);
			if (!(impulse < kUnlimited)) continue;
			forEachSide(row, bodies, [&](int side, int body) {
				// What turns presses at the radius of gyration.
				const bool turns = squaredNorm(pushOf(row, side).force) == 0;
				const double arm = turns ? std::sqrt(inertia / massOf(bodies[body])) : 1, force = impulse / (m_step * arm);
				if (std::isfinite(force)) m_motors[size_t(body)] = std::max(m_motors[size_t(body)], force);
			});
		}
}

/// Joins the islands that a joint connects, where the sum is not too large.
void btVolumetricIslands::joinByJoints(const btSolverBody* bodies)
{
	m_sizes.assign(m_parent.size(), Size());
	for (int body = 0; body < int(m_parent.size()); ++body) m_sizes[size_t(rootOf(body))].bodies += canMove(bodies[body]);
	for (const Entry& e : m_entries) ++m_sizes[size_t(rootOf(canMove(bodies[e.bodyA]) ? e.bodyA : e.bodyB))].patches;
	for (const Joint& joint : m_joints)
	{
		if (!joint.finite || !canMove(bodies[joint.bodyA]) || !canMove(bodies[joint.bodyB])) continue;
		const int a = rootOf(joint.bodyA), b = rootOf(joint.bodyB);
		const Size both = {m_sizes[size_t(a)].bodies + m_sizes[size_t(b)].bodies, m_sizes[size_t(a)].patches + m_sizes[size_t(b)].patches};
		if (a == b || both.bodies > kMaxBlockBodies || both.patches > kMaxBlockPatches) continue;
		m_parent[size_t(a)] = b;
		m_sizes[size_t(b)] = both;
	}
}

/// Gives each joint to its island, and takes its rows out of Bullet's iterations. Other joints touch the islands of their bodies.
void btVolumetricIslands::takeJoints(const btSolverBody* bodies)
{
	const auto islandOf = [&](int body) { return canMove(bodies[body]) ? m_islandOfRoot[size_t(rootOf(body))] : -1; };
	for (int i = int(m_joints.size()) - 1; i >= 0; --i)
	{
		Joint& joint = m_joints[size_t(i)];
		const int a = islandOf(joint.bodyA), b = islandOf(joint.bodyB), island = islandOf(movableBody(joint, bodies));
		const bool within = (a == island || !canMove(bodies[joint.bodyA])) && (b == island || !canMove(bodies[joint.bodyB]));
		if (island >= 0 && within && joint.finite && fitsBlock(m_islands[size_t(island)]))
		{
			joint.next = m_islands[size_t(island)].firstJoint;
			m_islands[size_t(island)].firstJoint = i;
			// Bullet visits a row in its first iterations, up to this number.
			for (int row = 0; row < joint.count; ++row) joint.rows[row].m_overrideNumSolverIterations = 0;
			continue;
		}
		for (const int touched : {a, b})
			if (touched >= 0) m_islands[size_t(touched)].touched = true;
	}
}

/// Takes the impulses of the joints so far out of the twists from which the block is solved.
void btVolumetricIslands::takeBackJoints(Block& block, const btSolverBody* bodies) const
{
	for (const btSolverConstraint* c : block.jointRows)
		forEachSide(*c, bodies, [&](int side, int body) {
			const ist::Vec3 center = toVec3(bodies[body].getWorldTransform().getOrigin());
			const ist::Wrench impulse = double(btScalar(c->m_appliedImpulse)) * pushOf(*c, side);
			ist::Twist& free = block.free[size_t(m_indexInBlock[size_t(body)])];
			free = free - response(rowBody(bodies[body]), impulse, center);
		});
}

// Bullet's row is (L cfm + J dv D) = rhs, with the change of velocity dv in this step and D = 1 / (J M^-1 J^T).
void btVolumetricIslands::addJointRows(Block& block, const Joint& joint, const btSolverBody* bodies)
{
	for (int i = 0; i < joint.count; ++i)
	{
		btSolverConstraint& c = joint.rows[i];
		const double perImpulse = double(c.m_jacDiagABInv);
		if (!(perImpulse > 0)) continue;
		btIslandJointRow row;
		row.wanted = double(c.m_rhs) / perImpulse;
		row.compliance = std::max(double(c.m_cfm) / perImpulse, 0.0);
		row.lower = double(c.m_lowerLimit);
		row.upper = double(c.m_upperLimit);
		for (int side = 0; side < 2; ++side)
		{
			const int body = side == 0 ? joint.bodyA : joint.bodyB;
			if (!canMove(bodies[body])) continue;
			const ist::Wrench push = pushOf(c, side);
			const ist::Twist before = twist(bodies[body]) - changeOf(bodies[body]);
			row.body[side] = m_indexInBlock[size_t(body)];
			const double J[6] = {push.force.x, push.force.y, push.force.z, push.torque.x, push.torque.y, push.torque.z};
			std::copy(std::begin(J), std::end(J), row.jacobian[side]);
			row.wanted += dot(push.force, before.linear) + dot(push.torque, before.angular);
		}
		block.solver.addJointRow(row);
		block.jointRows.push_back(&c);
	}
}

/// Writes the impulses of the joints into Bullet's rows, and adds their changes to those of the block.
double btVolumetricIslands::sumJoints(Block& block, const btSolverBody* bodies) const
{
	double residual = 0;
	for (size_t i = 0; i < block.jointRows.size(); ++i)
	{
		btSolverConstraint& c = *block.jointRows[i];
		const btScalar impulse = btScalar(block.solver.jointImpulse(int(i)));
		const double change = double(impulse) - double(btScalar(c.m_appliedImpulse));
		c.m_appliedImpulse = impulse;
		forEachSide(c, bodies, [&](int side, int body) {
			ist::Wrench& sum = block.impulses[size_t(m_indexInBlock[size_t(body)])];
			sum = sum + change * pushOf(c, side);
		});
		residual = std::max(residual, change * change);
	}
	return residual;
}
