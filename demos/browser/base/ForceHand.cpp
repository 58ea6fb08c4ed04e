// SPDX-License-Identifier: Zlib
#include "demos/browser/base/ForceHand.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

using namespace ist;
using namespace devicebridge;

namespace browser
{
namespace
{
constexpr double kStep = 1.0 / 60;  // length of the first step after the world is shown [s]

BulletDecoupledSettings settingsFor(const DeviceInfo& info, const AssumptionListener& say)
{
	BulletDecoupledSettings settings = BulletDecoupledSettings::forDevice(info, 1e-3, say);
	// Pictures come late from time to time, and contacts that faded at each of them would flicker.
	settings.fullUntil = 30'000'000;
	settings.zeroFrom = 100'000'000;
	return settings;
}
}  // namespace

HeldDevice::HeldDevice(Device& device, const Pose& X_WH, const Pose& X_WT, double scale)
	: m_device(device),
	  m_info(device.info()),
	  m_handle(X_WH.translation),
	  m_tool(X_WT.translation),
	  m_R_HT(transpose(X_WH.rotation) * X_WT.rotation),
	  m_scale(scale)
{
	scaleLimits(m_info, scale);
}

DeviceStatus HeldDevice::read(std::int64_t now, DeviceState& state) noexcept
{
	DeviceState own = state;
	const DeviceStatus status = m_device.read(now, own);
	if (status != DeviceStatus::Ok) return status;
	state = own;
	state.X_WH = {own.X_WH.rotation * m_R_HT, m_tool + m_scale * (own.X_WH.translation - m_handle)};
	state.twist.linear = m_scale * own.twist.linear;
	return status;
}

DeviceStatus HeldDevice::write(const DeviceCommand& command) noexcept
{
	DeviceCommand own = command;
	own.wrench.force = m_scale * command.wrench.force;
	return m_device.write(own);
}

Result<std::unique_ptr<ForceHand>> ForceHand::make(
	Device& device, DemoWorld& world, btRigidBody& tool, double scale, const AssumptionListener& say)
{
	if (!world.volumetric()) return Error{"forces come from volumetric contact: show the side that is not stock Bullet's"};
	if (tool.getNumConstraintRefs() > 0) return Error{"the tool hangs on a joint, and a hand beside the world holds it alone"};
	RealClock clock;
	DeviceState state;
	const std::int64_t end = clock.now() + 1'000'000'000;
	while (device.read(clock.now(), state) != DeviceStatus::Ok || !isRigid(state.X_WH))
	{
		if (clock.now() > end) return Error{"the device gives no sample: " + device.complaint()};
		clock.sleepUntil(clock.now() + 1'000'000);
	}
	std::unique_ptr<ForceHand> hand(new ForceHand(device, world, tool, state.X_WH, scale, say));
	if (!hand->m_thread.start()) return Error{hand->m_thread.refusal()};
	return hand;
}

ForceHand::ForceHand(Device& device, DemoWorld& world, btRigidBody& tool, const Pose& X_WH, double scale, const AssumptionListener& say)
	: m_world(world),
	  m_tool(tool),
	  m_device(device, X_WH, toPose(tool.getWorldTransform()), scale),
	  m_source(*world.volumetric(), tool, m_clock, settingsFor(m_device.info(), say)),
	  m_coupling(*world.volumetric()),
	  m_shown{toPose(tool.getWorldTransform()), {}, 0},
	  m_thread(m_device, m_source, m_clock)
{
	m_world.bullet().removeRigidBody(&m_tool);
	m_coupling.add(m_source);
	m_coupling.show(kStep);
	m_thread.onHapticTick.addDelegate([this](const DeviceState&, const Wrench&) {
		m_published.writable() = {m_thread.step().tool.X_WT, m_thread.sentWrench().force, m_thread.step().contactCount};
		m_published.publish();
	});
}

ForceHand::~ForceHand()
{
	m_thread.stop();
	m_coupling.remove(m_source);
	// The tool comes back at rest. The world would give it its own gravity, and it has not seen the pulls of the time before.
	const btVector3 gravity = m_tool.getGravity();
	m_tool.clearForces();
	m_tool.setLinearVelocity(btVector3(0, 0, 0));
	m_tool.setAngularVelocity(btVector3(0, 0, 0));
	m_world.bullet().addRigidBody(&m_tool);
	m_tool.setGravity(gravity);
}

void ForceHand::afterStep()
{
	m_coupling.afterStep();
	if (m_published.fetch()) m_shown = m_published.readable();
	const btTransform pose = toTransform(m_shown.X_WT);
	m_tool.setWorldTransform(pose);
	m_tool.setInterpolationWorldTransform(pose);
}

std::string ForceHand::state() const
{
	const FaultCause cause = m_thread.faultCause();
	return cause == FaultCause::None ? "felt at 1 kHz" : std::string("no force: ") + describe(cause);
}
}  // namespace browser
