// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletLocalWorld.h"

#include "DeviceBridge/Bullet/BulletToolContacts.h"

namespace devicebridge
{
namespace
{
bool isMovable(const btVolumetricRowBody& body)
{
	const ist::Mat3& inertia = body.inverseInertia;
	return body.inverseMass != ist::Vec3() || inertia.row(0) != ist::Vec3() || inertia.row(1) != ist::Vec3() ||
		inertia.row(2) != ist::Vec3();
}

ist::Mat3 inWorld(const ist::Mat3& tensor, const ist::Mat3& R) { return R * tensor * transpose(R); }

ist::Vec3 turnFrom(const ist::Mat3& before, const ist::Mat3& now) { return rotationVector(ist::quaternion(now * transpose(before))); }

ist::Mat3 turned(const ist::Mat3& R, const ist::Vec3& turn)
{
	return rotationMatrix(ist::quaternionFromRotationVector(turn) * ist::quaternion(R));
}
}  // namespace

void BulletLocalWorld::reconcile(const WorldSnapshot& world) noexcept
{
	for (int slot = 0; slot < kMirroredBodies; ++slot)
	{
		const MirroredBody& now = world.bodies[slot];
		Body& body = m_bodies[slot];
		SpentImpulse& copy = body.spent;
		if (now.epoch != copy.epoch)
		{
			body = {};
			copy.epoch = now.epoch;
			copy.X_WB = now.X_WB;
			copy.twist = now.twist;
			continue;
		}
		if (now.epoch == 0) continue;
		SpentImpulse then = now.seen;
		if (then.epoch != now.epoch)  // The world knows nothing of this copy yet, so the copy counts as still at its start.
			then = {}, then.X_WB = copy.X_WB, then.twist = copy.twist;
		copy.twist.linear += now.twist.linear - then.twist.linear;
		copy.twist.angular += now.twist.angular - then.twist.angular;
		body.shift = now.X_WB.translation - then.X_WB.translation - (copy.shifted - then.shifted);
		body.turn = turnFrom(then.X_WB.rotation, now.X_WB.rotation) - (copy.turned - then.turned);
		body.left = world.period;
		if (norm(body.shift) <= kTeleport) continue;
		copy.X_WB = putRight(slot);
		copy.shifted += body.shift;
		copy.turned += body.turn;
		body.shift = body.turn = {};
		body.share = 0;
	}
}

int BulletLocalWorld::indexOf(int slotOrTool) noexcept
{
	return slotOrTool >= 0 ? slotOrTool : slotOrTool == LinearContact::kTool ? kToolIndex : kFixedIndex;
}

/// Pose of the copy after its whole correction. The copy's supports are evaluated there. Otherwise a copy with a remaining error would be
/// pressed into its table by that error.
ist::Pose BulletLocalWorld::putRight(int slot) const noexcept
{
	if (slot < 0) return {};
	const Body& body = m_bodies[slot];
	const ist::Pose& X = body.spent.X_WB;
	return {turned(X.rotation, body.turn), X.translation + body.shift};
}

void BulletLocalWorld::step(double h, const ist::Wrench& pull, LinearContact* touching, int count, const WorldSnapshot& world) noexcept
{
	accelerate(h, pull, world);
	m_rowCount = 0;
	for (int i = 0; i < count; ++i) addRow(touching[i], h);
	for (int i = 0; i < world.contactCount; ++i)
	{
		const LinearContact& c = world.contacts[i];
		const LinearContact moved = movedTo(c, putRight(c.a), putRight(c.b));
		if (isFinite(moved.wrench) && isFinite(moved.point)) addRow(moved, h);
	}
	solve();
	enterSpent(touching, count);
	move(h, world);
}

void BulletLocalWorld::accelerate(double h, const ist::Wrench& pull, const WorldSnapshot& world) noexcept
{
	for (int slot = 0; slot < kMirroredBodies; ++slot)
	{
		const MirroredBody& body = world.bodies[slot];
		const SpentImpulse& copy = m_bodies[slot].spent;
		m_twists[slot] = copy.twist;
		if (body.epoch == 0) continue;
		m_rowBodies[slot] = {body.inverseMass, inWorld(body.inverseInertia, copy.X_WB.rotation), copy.X_WB.translation};
		if (body.inverseMass != ist::Vec3{}) m_twists[slot].linear += h * body.gravity;
	}
	const double inverse = 1 / tool.mass;
	const ist::Pose& X_WT = tool.state.X_WT;
	m_rowBodies[kToolIndex] = {{inverse, inverse, inverse}, inWorld(tool.inverseInertia, X_WT.rotation), X_WT.translation};
	m_twists[kToolIndex] = tool.state.twist;
	m_twists[kToolIndex].linear += h * tool.gravity;
	kick(kToolIndex, X_WT.translation, h * pull);
}

void BulletLocalWorld::addRow(const LinearContact& c, double h) noexcept
{
	const int a = indexOf(c.a), b = indexOf(c.b), row = m_rowCount++;
	m_rowA[row] = a;
	m_rowB[row] = b;
	m_rows[row].prepare(contactPatch(c), m_rowBodies[a], m_rowBodies[b], h, c.friction);
}

void BulletLocalWorld::kick(int index, const ist::Vec3& point, const ist::Wrench& impulse) noexcept
{
	const btVolumetricRowBody& body = m_rowBodies[index];
	ist::Twist& twist = m_twists[index];
	for (int i = 0; i < 3; ++i) twist.linear[i] += body.inverseMass[i] * impulse.force[i];
	twist.angular += body.inverseInertia * (impulse.torque + cross(point - body.center, impulse.force));
}

ist::Twist BulletLocalWorld::twistAt(int index, const ist::Vec3& point) const noexcept
{
	const ist::Twist& twist = m_twists[index];
	return {twist.linear + cross(twist.angular, point - m_rowBodies[index].center), twist.angular};
}

/// Each row is checked by itself, because the force of a heavy body on its support would hide the forces that the hand feels.
bool BulletLocalWorld::isSettled(const ist::Wrench& change, const ist::Wrench& whole) noexcept
{
	return norm(change.force) <= kSettled * norm(whole.force) + kSettledForce &&
		norm(change.torque) <= kSettled * norm(whole.torque) + kSettledTorque;
}

void BulletLocalWorld::solve() noexcept
{
	bool moves[kIndices], stands[kIndices];  // a body that others move is neither
	for (int i = 0; i < kIndices; ++i)
	{
		moves[i] = isMovable(m_rowBodies[i]);
		stands[i] = !moves[i] && m_twists[i].linear == ist::Vec3() && m_twists[i].angular == ist::Vec3();
	}
	const auto twistOf = [&](int index, const ist::Vec3& point) { return stands[index] ? ist::Twist() : twistAt(index, point); };
	for (int sweep = 0; sweep < kSweeps; ++sweep)
	{
		bool settled = true;
		for (int row = 0; row < m_rowCount; ++row)
		{
			const ist::Vec3& point = m_rows[row].point();
			const ist::Twist a = twistOf(m_rowA[row], point), b = twistOf(m_rowB[row], point);
			const ist::Wrench change = m_rows[row].solve({a.linear - b.linear, a.angular - b.angular}), whole = m_rows[row].impulse();
			if (moves[m_rowA[row]]) kick(m_rowA[row], point, change);
			if (moves[m_rowB[row]]) kick(m_rowB[row], point, -1.0 * change);
			settled = settled && isSettled(change, whole);
		}
		if (settled) return;
	}
}

void BulletLocalWorld::enterSpent(const LinearContact* touching, int count) noexcept
{
	for (int i = 0; i < count; ++i)
	{
		m_impulses[i] = m_rows[i].impulse();
		if (!isFinite(m_impulses[i])) m_impulses[i] = {};  // only finite impulses are passed on
		m_given += m_impulses[i].force;
		SpentImpulse& copy = m_bodies[touching[i].b].spent;
		const ist::Wrench onBody = -1.0 * m_impulses[i];
		copy.impulse.force += onBody.force;
		copy.impulse.torque += onBody.torque + cross(m_rows[i].point() - copy.X_WB.translation, onBody.force);
	}
}

void BulletLocalWorld::move(double h, const WorldSnapshot& world) noexcept
{
	for (int slot = 0; slot < kMirroredBodies; ++slot)
	{
		if (world.bodies[slot].epoch == 0) continue;
		Body& body = m_bodies[slot];
		SpentImpulse& copy = body.spent;
		const double part = body.left > h ? h / body.left : 1;
		const ist::Vec3 shift = part * body.shift, turn = part * body.turn;
		body.left -= h;
		body.shift -= shift;
		body.turn -= turn;
		copy.shifted += shift;
		copy.turned += turn;
		copy.twist = isFinite(m_twists[slot]) ? m_twists[slot] : ist::Twist();
		copy.X_WB = {turned(copy.X_WB.rotation, h * copy.twist.angular + turn), copy.X_WB.translation + h * copy.twist.linear + shift};
		copy.area = copy.area + h * copy.impulse;
		copy.seconds += h;
	}
	ToolState& t = tool.state;
	m_toolIsBroken = !isFinite(m_twists[kToolIndex]);
	t.twist = m_toolIsBroken ? ist::Twist() : m_twists[kToolIndex];
	t.X_WT = {turned(t.X_WT.rotation, h * t.twist.angular), t.X_WT.translation + h * t.twist.linear};
}
}  // namespace devicebridge
