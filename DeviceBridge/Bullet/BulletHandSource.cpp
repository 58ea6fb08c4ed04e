// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletHandSource.h"

#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Bullet/BulletContactImpulse.h"

#include <algorithm>
#include <limits>

using namespace ist;

namespace devicebridge
{
BulletHandSource::BulletHandSource(btISTWorld& world, BulletHand& hand, Device& device, const Pose& X_BW)
	: m_world(world),
	  m_hand(hand),
	  m_device(device),
	  m_X_BW(X_BW),
	  m_X_WB(inverse(X_BW))
{
	m_world.contacts().measureQueryTime(true);
	m_joints.left = hand.model().shape.left;
}

void BulletHandSource::prepare(double dt, const DeviceState& hand) noexcept
{
	m_isPrepared = true;
	m_preparedAt = m_world.contacts().step();
	m_origin = toVec3(m_hand.body(kHandPart).getWorldTransform().getOrigin());
	if ((hand.flags & kHandPresent) == 0 || !m_device.readHand(m_joints))
		for (HandJoint& joint : m_joints.joints) joint.tracked = false;
	else moveHand(m_joints, m_X_BW);
	m_hand.drive(m_joints, dt);
}

void BulletHandSource::advance(double dt, const DeviceState& hand, ToolStep& step) noexcept
{
	if (!m_isPrepared) prepare(dt, hand);
	m_isPrepared = false;
	btISTContactStore& store = m_world.contacts();
	if (store.step() == m_preparedAt)
	{
		store.resetQueryTime();
		m_world.bullet().stepSimulation(btScalar(dt), 0);
		step.queryMicroseconds = 1e6 * store.querySeconds();
	}
	const btRigidBody& palm = m_hand.body(kHandPart);
	const Mat3& R_WB = m_X_WB.rotation;
	step.tool = {
		m_X_WB * toPose(palm.getWorldTransform()), {R_WB * toVec3(palm.getLinearVelocity()), R_WB * toVec3(palm.getAngularVelocity())}};
	for (int part = 0; part < kHandParts; ++part)
	{
		const btRigidBody& body = m_hand.body(part);
		const Twist twist{toVec3(body.getLinearVelocity()), toVec3(body.getAngularVelocity())};
		step.toolIsBroken = step.toolIsBroken || !isFinite(twist) || !isRigid(toPose(body.getWorldTransform()));
	}
	sumCouplings(step);
	collectContacts(dt, step);
}

void BulletHandSource::sumCouplings(ToolStep& step) const noexcept
{
	Wrench sum;
	for (int part = 0; part < kHandParts; ++part)
	{
		const Wrench& coupling = m_hand.coupling(part);
		const Vec3 arm = toVec3(m_hand.body(part).getWorldTransform().getOrigin()) -
			toVec3(m_hand.body(kHandPart).getWorldTransform().getOrigin());
		sum.force += coupling.force;
		sum.torque += coupling.torque + cross(arm, coupling.force);
	}
	step.coupling = {m_X_WB.rotation * sum.force, m_X_WB.rotation * sum.torque};
}

/// The step's contact with a body, which may be a new one; null if there is no room for another.
ToolContact* BulletHandSource::contactWith(const void* other, ToolStep& step) const noexcept
{
	for (int i = 0; i < step.contactCount; ++i)
		if (step.contacts[i].other == other) return &step.contacts[i];
	if (step.contactCount == kMaxToolContacts) return nullptr;
	ToolContact& added = step.contacts[step.contactCount++];
	added = {};
	added.other = other;
	return &added;
}

void BulletHandSource::collectContacts(double dt, ToolStep& step) const noexcept
{
	const Mat3& R_WB = m_X_WB.rotation;
	for (const btISTContact* contact : m_world.contacts().contacts())
	{
		if (!touchedInLastStep(m_world.contacts(), *contact)) continue;
		const bool handIsA = m_hand.partOf(contact->bodyA) >= 0;
		if (handIsA == (m_hand.partOf(contact->bodyB) >= 0)) continue;
		step.overlapVolume += contact->total.volume;
		step.pairs += contact->total.pairs;
		ToolContact* out = contactWith(handIsA ? contact->bodyB : contact->bodyA, step);
		if (!out) continue;
		const double sign = handIsA ? 1 : -1, rate = dt > 0 ? sign / dt : 0;
		const Wrench impulse = impulseOnA(*contact, m_origin);
		out->onTool.force += R_WB * (rate * impulse.force);
		out->onTool.torque += R_WB * (rate * impulse.torque);
		// The point is the centroid of the overlaps with this body, and the normal the mean of the parts' normals.
		const Vec3 centroid = m_X_WB * centroidInWorld(*contact, contact->total);
		const Vec3 normal = R_WB * (contact->X_WA.rotation * (sign * normalized(contact->total.areaVector)));
		const double volume = out->volume + contact->total.volume, share = volume > 0 ? contact->total.volume / volume : 1;
		out->point += share * (centroid - out->point);
		out->normal = normalized((1 - share) * out->normal + share * normal);
		out->volume += contact->total.volume;
		out->pairs = static_cast<int>(std::min<std::int64_t>(out->pairs + contact->total.pairs, std::numeric_limits<int>::max()));
	}
}
}  // namespace devicebridge
