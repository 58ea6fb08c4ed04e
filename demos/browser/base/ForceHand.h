// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletWorldCoupling.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Timing/TripleBuffer.h"
#include "demos/browser/base/DemoWorld.h"

#include <memory>

namespace browser
{
/// A device as a tool feels it: where the handle is at first, the tool is, and one metre of the handle is `scale` metres of the world.
/// Power is preserved, as by devicebridge::MountedDevice. It does not own the device.
class HeldDevice final : public devicebridge::Device
{
public:
	HeldDevice(devicebridge::Device& device, const ist::Pose& X_WH, const ist::Pose& X_WT, double scale);
	const devicebridge::DeviceInfo& info() const noexcept override { return m_info; }
	devicebridge::DeviceStatus open() noexcept override { return devicebridge::DeviceStatus::Ok; }
	void close() noexcept override {}
	devicebridge::DeviceStatus read(std::int64_t now, devicebridge::DeviceState& state) noexcept override;
	devicebridge::DeviceStatus write(const devicebridge::DeviceCommand& command) noexcept override;

private:
	devicebridge::Device& m_device;
	devicebridge::DeviceInfo m_info;
	ist::Vec3 m_handle, m_tool;  // positions at first
	ist::Mat3 m_R_HT;            // orientation of the tool on the handle
	double m_scale;
};

/// A hand that feels a demo's tool, with a thread of 1 kHz of its own beside the demo's world. While it exists, the tool is not in the
/// world: the hand's thread moves it against copies of the bodies near it (BulletDecoupledSource), and this object shows it where it is.
/// All members are for the thread of the world.
class ForceHand
{
public:
	/// `device` is open and answers; it and the world must outlive this object. `tool` is a body of the world with a tree. Refused, with
	/// the reason: a device that gives no sample within a second, a tool that cannot be coupled, no thread. Where no limits of the device
	/// are known, `say` says what is assumed.
	static ist::Result<std::unique_ptr<ForceHand>> make(
		devicebridge::Device& device, DemoWorld& world, btRigidBody& tool, double scale, const devicebridge::AssumptionListener& say = {});
	/// Stops the thread, and leaves the device at zero and the tool in the world, at rest and with its gravity.
	~ForceHand();
	ForceHand(const ForceHand&) = delete;
	ForceHand& operator=(const ForceHand&) = delete;

	/// The demo calls these around its one step of a picture.
	void beforeStep(double h) { m_coupling.beforeStep(h); }
	void afterStep();
	/// Newest force on the hand as the world feels it, before the scale [N], in World.
	const ist::Vec3& force() const { return m_shown.force; }
	/// Number of bodies that the tool touches.
	int contacts() const { return m_shown.contacts; }
	/// What the hand does and why it feels nothing, in words: "felt at 1 kHz", "no force: the device is lost".
	std::string state() const;
	std::uint64_t ticks() const { return m_thread.ticks(); }

private:
	struct Shown
	{
		ist::Pose X_WT;
		ist::Vec3 force;
		int contacts = 0;
	};
	ForceHand(devicebridge::Device& device, DemoWorld& world, btRigidBody& tool, const ist::Pose& X_WH, double scale,
		const devicebridge::AssumptionListener& say);

	DemoWorld& m_world;
	btRigidBody& m_tool;
	devicebridge::RealClock m_clock;
	HeldDevice m_device;
	devicebridge::BulletDecoupledSource m_source;
	devicebridge::BulletWorldCoupling m_coupling;
	devicebridge::TripleBuffer<Shown> m_published;
	Shown m_shown;
	devicebridge::SteppingThread m_thread;
};
}  // namespace browser
