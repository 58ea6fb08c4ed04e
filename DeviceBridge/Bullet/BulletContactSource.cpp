// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletContactSource.h"

#include "BulletHapticForce/Law/btContactLaw.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Bullet/BulletContactImpulse.h"

#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletDynamics/Dynamics/btDynamicsWorld.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace devicebridge
{
namespace
{
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// The least principal inertia, because the coupling takes a single inertia and is stable with any that is not too large.
double leastInertia(const btRigidBody& body)
{
	const btVector3& inverse = body.getInvInertiaDiagLocal();
	const double largest = std::max({double(inverse.x()), double(inverse.y()), double(inverse.z())});
	return largest > 0 ? 1 / largest : kInfinite;
}

const char* whyNotLed(const btRigidBody& tool, const BulletToolSettings& settings)
{
	const CouplingGains& gains = settings.gains;
	if (tool.getInvMass() == 0)
		return "the tool has mass 0, and Bullet never moves such a body of its world: give it a mass, of which a static coupling lets only "
			   "the weight be felt";
	const char* why = whyNotCoupled(gains, double(tool.getInvMass()), toVec3(tool.getInvInertiaDiagLocal()));
	return why[0] != '\0' || settings.mayBeSilent ? why : whyNotMoved(gains);
}
}  // namespace

BulletContactSource::BulletContactSource(
	btDynamicsWorld& world, btISTContactStore& store, btRigidBody& tool, const BulletToolSettings& settings)
	: m_world(world),
	  m_store(store),
	  m_tool(tool),
	  m_settings(settings),
	  m_coupling(settings.gains),
	  m_X_WB(inverse(settings.X_BW)),
	  m_mass(tool.getInvMass() > 0 ? 1 / double(tool.getInvMass()) : kInfinite),
	  m_refusal(whyNotLed(tool, settings))
{
	m_tool.forceActivationState(DISABLE_DEACTIVATION);
	m_store.measureQueryTime(true);
	if (m_coupling.adapts()) m_store.sumDamping(true);  // a damper resists with any solver
	if (settings.gravity) return;
	m_tool.setFlags(m_tool.getFlags() | BT_DISABLE_WORLD_GRAVITY);
	m_tool.setGravity(btVector3(0, 0, 0));
}

void BulletContactSource::prepare(double dt, const DeviceState& hand) noexcept
{
	m_isPrepared = true;
	m_preparedAt = m_store.step();
	m_toolOrigin = toVec3(m_tool.getWorldTransform().getOrigin());
	// A static coupling gives the tool the mass of a spring times the square of the step.
	if (m_settings.gains.isStatic && !(dt > 0)) return;
	DeviceState leading = hand;
	m_pull = {};
	if (!m_switch.lead(leading, toolState(), dt)) return;
	adapt(dt, leading);
	forgetMomentum(dt);
	m_pull = pull(dt, leading);
	applyToTool(m_pull);
}

void BulletContactSource::advance(double dt, const DeviceState& hand, ToolStep& step) noexcept
{
	if (!m_isPrepared) prepare(dt, hand);
	m_isPrepared = false;
	if (m_settings.gains.isStatic && !(dt > 0))
	{
		step.coupling = {};
		step.tool = toolState();
		return;
	}
	if (m_store.step() == m_preparedAt) stepWorld(dt, step);
	step.tool = toolState();
	step.toolIsBroken = !isFinite(step.tool.twist) || !isRigid(step.tool.X_WT);
	step.couplingFactor = m_coupling.factor();
	step.coupling = m_settings.gains.isStatic ? staticWrench(m_coupling.gains(), m_pull, step.tool.twist, dt) : m_pull;
	collectContacts(dt, step);
}

void BulletContactSource::stepWorld(double dt, ToolStep& step) noexcept
{
	m_store.resetQueryTime();
	m_world.stepSimulation(btScalar(dt), 0);
	step.queryMicroseconds = 1e6 * m_store.querySeconds();
}

ToolState BulletContactSource::toolState() const noexcept
{
	const ist::Mat3& R_WB = m_X_WB.rotation;
	return {m_X_WB * toPose(m_tool.getWorldTransform()),
		{R_WB * toVec3(m_tool.getLinearVelocity()), R_WB * toVec3(m_tool.getAngularVelocity())}};
}

/// Whether the tool touches by Bullet's own contacts or by joints, whose stiffness is unknown.
bool BulletContactSource::isHeldByBullet() const noexcept
{
	if (m_tool.getNumConstraintRefs() > 0) return true;
	btDispatcher& dispatcher = *m_world.getDispatcher();
	for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
	{
		const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
		const bool ofTool = manifold->getBody0() == &m_tool || manifold->getBody1() == &m_tool;
		if (ofTool && manifold->getNumContacts() > 0 && !m_store.find(manifold)) return true;
	}
	return false;
}

/// Adapts the coupling to the contacts of the previous step, because those of this step are not found yet.
void BulletContactSource::adapt(double dt, const DeviceState& hand) noexcept
{
	if (!m_coupling.adapts() || !(dt > 0)) return;
	ist::SymmetricMatrix6 resistance;
	bool rigid = isHeldByBullet();
	btContactPatch patch;
	for (const btISTContact* contact : m_store.contacts())
	{
		if (!isFresh(*contact)) continue;
		rigid = rigid || gCalculateCombinedFrictionCallback(contact->bodyA, contact->bodyB) > 0;
		for (int i = 0; i < contact->patchCount; ++i)
			if (evaluateContactPatch(*contact, i, patch))
				addResistance(resistance, patch.stiffness, patch.damping, patch.point - toVec3(m_tool.getWorldTransform().getOrigin()), dt);
	}
	const bool hasMass = !m_settings.gains.isStatic;
	// No spring acts on a tool's rotation if the tool cannot turn.
	const double least = leastInertia(m_tool), inertia = hasMass && std::isfinite(least) ? least : 0;
	m_coupling.adapt(resistance, rigid, hasMass ? m_mass : 0, inertia, hand.X_WH, toolState().X_WT, dt);
}

ist::Wrench BulletContactSource::pull(double dt, const DeviceState& hand) const noexcept
{
	if (m_refusal[0] != '\0' || !isRigid(hand.X_WH) || !isFinite(hand.twist)) return {};
	if (m_settings.gains.isStatic) return staticPull(m_coupling.gains(), hand.X_WH, toolState().X_WT);
	const double inverseMass = double(m_tool.getInvMass());
	const double mass = inverseMass > 0 ? 1 / inverseMass : kInfinite;
	ist::Wrench wanted = couplingOnTool(m_coupling.gains(), hand.X_WH, hand.twist, toolState(), mass, leastInertia(m_tool), dt);
	return isFinite(wanted) ? wanted : ist::Wrench();
}

/// Clears the tool's momentum before a step on a static coupling.
void BulletContactSource::forgetMomentum(double dt) noexcept
{
	const CouplingGains& gains = m_coupling.gains();
	if (!gains.isStatic || m_refusal[0] != '\0' || !(m_tool.getInvMass() > 0)) return;
	const bool turns = gains.angularStiffness > 0, goes = gains.stiffness > 0;
	const btVector3 inverse = m_tool.getInvInertiaDiagLocal();
	const btVector3 before(
		inverse.x() > 0 ? 1 / inverse.x() : 0, inverse.y() > 0 ? 1 / inverse.y() : 0, inverse.z() > 0 ? 1 / inverse.z() : 0);
	const btScalar inertia = btScalar(staticMass(gains.angularStiffness, dt));
	const double mass = goes ? staticMass(gains.stiffness, dt) : m_mass;
	m_tool.setMassProps(btScalar(mass), turns ? btVector3(inertia, inertia, inertia) : before);
	m_tool.updateInertiaTensor();
	// The weight remains that of the original mass.
	m_tool.applyCentralForce(m_tool.getGravity() * btScalar(m_mass - mass));
	if (goes) m_tool.setLinearVelocity(btVector3(0, 0, 0));
	if (turns) m_tool.setAngularVelocity(btVector3(0, 0, 0));
}

void BulletContactSource::applyToTool(const ist::Wrench& inW) noexcept
{
	const ist::Mat3& R_BW = m_settings.X_BW.rotation;
	m_tool.applyCentralForce(toBullet(R_BW * inW.force));
	m_tool.applyTorque(toBullet(R_BW * inW.torque));
}

/// Whether it is a contact of the tool in the step just taken. The solver already counts the next step; an older contact sleeps or was not
/// evaluated.
bool BulletContactSource::isFresh(const btISTContact& contact) const noexcept
{
	return contact.stamp + 1 == m_store.step() && contact.patchCount > 0 && (contact.bodyA == &m_tool || contact.bodyB == &m_tool);
}

void BulletContactSource::collectContacts(double dt, ToolStep& step) const noexcept
{
	for (const btISTContact* contact : m_store.contacts())
	{
		if (!isFresh(*contact)) continue;
		step.overlapVolume += contact->total.volume;
		step.pairs += contact->total.pairs;
		if (step.contactCount < kMaxToolContacts) step.contacts[step.contactCount++] = contactInW(*contact, dt);
	}
}

ToolContact BulletContactSource::contactInW(const btISTContact& contact, double dt) const noexcept
{
	const bool toolIsA = contact.bodyA == &m_tool;
	const double sign = toolIsA ? 1 : -1;
	const ist::Wrench impulse = impulseOnA(contact, m_toolOrigin);
	ToolContact out;
	const ist::Mat3& R_WB = m_X_WB.rotation;
	const double rate = dt > 0 ? sign / dt : 0;
	out.onTool = {R_WB * (rate * impulse.force), R_WB * (rate * impulse.torque)};
	out.point = m_X_WB * centroidInWorld(contact, contact.total);
	out.normal = R_WB * (contact.X_WA.rotation * (sign * normalized(contact.total.areaVector)));
	out.volume = contact.total.volume;
	out.pairs = static_cast<int>(std::min<std::int64_t>(contact.total.pairs, std::numeric_limits<int>::max()));
	out.other = toolIsA ? contact.bodyB : contact.bodyA;
	return out;
}
}  // namespace devicebridge
