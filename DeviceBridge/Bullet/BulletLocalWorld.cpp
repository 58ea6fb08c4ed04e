// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletLocalWorld.h"

#include "DeviceBridge/Bullet/BulletToolContacts.h"

#include <algorithm>

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

/// The part of a correction that a copy still needs. The correction was found at the copy as the world knew it, and since then the copy has
/// changed by `own`. Supports of the copy may have made a part of the correction within that time, as those of the body did: they stop a
/// body that falls. Such a part is not made twice. `expected` is the change that the tool's impulses and the body's velocity explain.
ist::Vec3 remaining(const ist::Vec3& correction, const ist::Vec3& own, const ist::Vec3& expected)
{
	const double size = squaredNorm(correction);
	if (!(size > 0)) return correction;
	const double made = dot(own, correction) - std::max(0.0, dot(expected, correction));
	return (1 - std::clamp(made / size, 0.0, 1.0)) * correction;
}
}  // namespace

BulletLocalWorld::BulletLocalWorld(int slots)
	: m_bodies(std::size_t(slots)),
	  m_places(std::size_t(slots) + 2),
	  m_rows(std::size_t(contactCapacity(slots) + kToolContactsPerSlot * slots)),
	  m_impulses(std::size_t(kToolContactsPerSlot * slots))
{}

void BulletLocalWorld::reconcile(const WorldSnapshot& world) noexcept
{
	for (std::size_t slot = 0; slot < m_bodies.size(); ++slot)
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
		correct(body, now, world.period);
		if (norm(body.shift) <= kTeleport && !m_held) continue;
		copy.X_WB = putRight(int(slot));
		copy.shifted += body.shift;
		copy.turned += body.turn;
		body.shift = body.turn = {};
		body.share = 0;
	}
}

/// Finds the corrections of a copy, and corrects its velocity.
void BulletLocalWorld::correct(Body& body, const MirroredBody& now, double period) const noexcept
{
	SpentImpulse& copy = body.spent;
	// The body is compared with the present copy if the world does not know the copy yet, or knew it too long ago.
	const bool comparable = !m_held && now.seen.epoch == now.epoch && copy.seconds - now.seen.seconds <= kComparedPeriods * period;
	const SpentImpulse& then = comparable ? now.seen : copy;
	const double since = copy.seconds - then.seconds;
	const ist::Wrench given = copy.impulse - then.impulse, area = copy.area - then.area - since * then.impulse;
	const ist::Mat3 inverseInertia = inWorld(now.inverseInertia, copy.X_WB.rotation);
	const ist::Twist quickened = copy.quickened - then.quickened;
	const ist::Vec3 shifted = copy.shifted - then.shifted, turning = copy.turned - then.turned;
	const ist::Twist known = then.twist + quickened, missing = now.twist - known, own = copy.twist - known;
	const ist::Twist change = {remaining(missing.linear, own.linear, componentProduct(now.inverseMass, given.force)),
		remaining(missing.angular, own.angular, inverseInertia * given.torque)};
	copy.twist = copy.twist + change;
	copy.quickened = copy.quickened + change;
	body.shift = remaining(now.X_WB.translation - then.X_WB.translation - shifted, copy.X_WB.translation - then.X_WB.translation - shifted,
		since * now.twist.linear + componentProduct(now.inverseMass, area.force));
	body.turn = remaining(turnFrom(then.X_WB.rotation, now.X_WB.rotation) - turning,
		turnFrom(then.X_WB.rotation, copy.X_WB.rotation) - turning, since * now.twist.angular + inverseInertia * area.torque);
	body.left = period;
}

void BulletLocalWorld::hold(bool held) noexcept
{
	m_held = held;
	if (!held) return;
	for (Body& body : m_bodies)
	{
		SpentImpulse& copy = body.spent;
		copy.quickened = copy.quickened - copy.twist;
		copy.twist = {};
		body.share = 0;
	}
}

std::size_t BulletLocalWorld::placeOf(int slotOrTool) const noexcept
{
	return slotOrTool >= 0 ? std::size_t(slotOrTool) : m_bodies.size() + (slotOrTool == LinearContact::kTool ? 0 : 1);
}

/// Pose of the copy after its whole correction. The copy's supports are evaluated there. Otherwise a copy with a remaining error would be
/// pressed into its table by that error.
ist::Pose BulletLocalWorld::putRight(int slot) const noexcept
{
	if (slot < 0) return {};
	const Body& body = this->body(slot);
	const ist::Pose& X = body.spent.X_WB;
	return {turned(X.rotation, body.turn), X.translation + body.shift};
}

void BulletLocalWorld::step(double h, const ist::Wrench& pull, LinearContact* touching, int count, const WorldSnapshot& world) noexcept
{
	accelerate(h, pull, world);
	m_rowCount = 0;
	for (int i = 0; i < count; ++i) addRow(touching[i], h);
	for (int i = 0; i < world.contactCount && !m_held; ++i)
	{
		const LinearContact& c = world.contacts[std::size_t(i)];
		const LinearContact moved = movedTo(c, putRight(c.a), putRight(c.b));
		if (isFinite(moved.wrench) && isFinite(moved.point)) addRow(moved, h);
	}
	solve();
	enterSpent(touching, count);
	move(h, world);
}

void BulletLocalWorld::accelerate(double h, const ist::Wrench& pull, const WorldSnapshot& world) noexcept
{
	for (std::size_t slot = 0; slot < m_bodies.size(); ++slot)
	{
		const MirroredBody& body = world.bodies[slot];
		const SpentImpulse& copy = m_bodies[slot].spent;
		Place& place = m_places[slot];
		place.twist = copy.twist;
		if (body.epoch == 0) continue;
		place.body = {{}, ist::zeroMat3(), copy.X_WB.translation};
		if (m_held) continue;
		place.body = {body.inverseMass, inWorld(body.inverseInertia, copy.X_WB.rotation), copy.X_WB.translation};
		if (body.inverseMass != ist::Vec3{}) place.twist.linear += h * body.gravity;
	}
	const double inverse = 1 / tool.mass;
	const ist::Pose& X_WT = tool.state.X_WT;
	toolPlace().body = {{inverse, inverse, inverse}, inWorld(tool.inverseInertia, X_WT.rotation), X_WT.translation};
	toolPlace().twist = tool.state.twist;
	toolPlace().twist.linear += h * tool.gravity;
	kick(toolPlace(), X_WT.translation, h * pull);
}

void BulletLocalWorld::addRow(const LinearContact& c, double h) noexcept
{
	Row& row = m_rows[m_rowCount++];
	row.a = placeOf(c.a);
	row.b = placeOf(c.b);
	row.row.prepare(contactPatch(c), m_places[row.a].body, m_places[row.b].body, h, c.friction);
}

void BulletLocalWorld::kick(Place& place, const ist::Vec3& point, const ist::Wrench& impulse) noexcept
{
	for (int i = 0; i < 3; ++i) place.twist.linear[i] += place.body.inverseMass[i] * impulse.force[i];
	place.twist.angular += place.body.inverseInertia * (impulse.torque + cross(point - place.body.center, impulse.force));
}

ist::Twist BulletLocalWorld::twistAt(const Place& place, const ist::Vec3& point) noexcept
{
	return {place.twist.linear + cross(place.twist.angular, point - place.body.center), place.twist.angular};
}

/// Each row is checked by itself, because the force of a heavy body on its support would hide the forces that the hand feels.
bool BulletLocalWorld::isSettled(const ist::Wrench& change, const ist::Wrench& whole) noexcept
{
	return norm(change.force) <= kSettled * norm(whole.force) + kSettledForce &&
		norm(change.torque) <= kSettled * norm(whole.torque) + kSettledTorque;
}

void BulletLocalWorld::solve() noexcept
{
	for (Place& place : m_places)
	{
		place.moves = isMovable(place.body);
		place.stands = !place.moves && place.twist.linear == ist::Vec3() && place.twist.angular == ist::Vec3();
	}
	const auto twistOf = [](const Place& place, const ist::Vec3& point) { return place.stands ? ist::Twist() : twistAt(place, point); };
	for (int sweep = 0; sweep < kSweeps; ++sweep)
	{
		bool settled = true;
		for (std::size_t i = 0; i < m_rowCount; ++i)
		{
			btVolumetricRow& row = m_rows[i].row;
			Place &A = m_places[m_rows[i].a], &B = m_places[m_rows[i].b];
			const ist::Vec3& point = row.point();
			const ist::Twist a = twistOf(A, point), b = twistOf(B, point);
			const ist::Wrench change = row.solve({a.linear - b.linear, a.angular - b.angular}), whole = row.impulse();
			if (A.moves) kick(A, point, change);
			if (B.moves) kick(B, point, -1.0 * change);
			settled = settled && isSettled(change, whole);
		}
		if (settled) return;
	}
}

void BulletLocalWorld::enterSpent(const LinearContact* touching, int count) noexcept
{
	for (int i = 0; i < count; ++i)
	{
		const btVolumetricRow& row = m_rows[std::size_t(i)].row;  // the rows of the tool come first
		ist::Wrench& impulse = m_impulses[std::size_t(i)];
		impulse = row.impulse();
		if (!isFinite(impulse)) impulse = {};  // only finite impulses are passed on
		m_given += impulse.force;
		SpentImpulse& copy = body(touching[i].b).spent;
		const ist::Wrench onBody = -1.0 * impulse;
		copy.impulse.force += onBody.force;
		copy.impulse.torque += onBody.torque + cross(row.point() - copy.X_WB.translation, onBody.force);
	}
}

void BulletLocalWorld::move(double h, const WorldSnapshot& world) noexcept
{
	for (std::size_t slot = 0; slot < m_bodies.size(); ++slot)
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
		copy.twist = isFinite(m_places[slot].twist) ? m_places[slot].twist : ist::Twist();
		copy.X_WB = {turned(copy.X_WB.rotation, h * copy.twist.angular + turn), copy.X_WB.translation + h * copy.twist.linear + shift};
		copy.area = copy.area + h * copy.impulse;
		copy.seconds += h;
	}
	ToolState& t = tool.state;
	m_toolIsBroken = !isFinite(toolPlace().twist);
	t.twist = m_toolIsBroken ? ist::Twist() : toolPlace().twist;
	t.X_WT = {turned(t.X_WT.rotation, h * t.twist.angular), t.X_WT.translation + h * t.twist.linear};
}
}  // namespace devicebridge
