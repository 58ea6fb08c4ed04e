// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btVolumetricRows.h"
#include "DeviceBridge/Loop/WorldMirror.h"

namespace devicebridge
{
/// The tool, with the hand's thread as its only owner.
struct LocalTool
{
	double mass = 1;                             ///< [kg]
	ist::Mat3 inverseInertia = ist::zeroMat3();  ///< axes of T [1/(kg m^2)]
	ist::Vec3 gravity;                           ///< World [m/s^2]
	ToolState state;                             ///< in World
};

/// The hand's own copy of the bodies near the tool, which lives from one step of the world to the next and a little longer. The copies
/// move under gravity, under the tool, and on what carries them (a linear model of each contact, as the world left it), with the same
/// implicit rows that the world is solved with; so a light body gives way to the tool within a tick, and not by what an impulse of a
/// whole step of the world would do to it. What the tool gives to a copy is added up, and the world gets exactly that.
///
/// When the world has taken a step, its body and the copy as the world knew it are compared, and the difference is put right: of the
/// velocity at once, of the pose over one period, so that no contact jumps.
///
/// Why this is passive: let J be the sum of a period. The tool's work on a free copy is J.(u0 + J/2m) with u0 its velocity when the
/// world was published. The world puts J on the body at that very velocity: the same energy. What carries the body can only take from
/// it. Only putting a pose right can do work on the tool; the passivity controller of the device stands behind that.
/// One thread, no allocation.
class BulletLocalWorld
{
public:
	static constexpr double kTeleport = 0.05;  ///< a copy that is further off is put right at once, and its contact fades in anew [m]

	/// A new snapshot.
	void reconcile(const WorldSnapshot& world) noexcept;
	/// One step of `h` [s] with `pull` on the tool about its centre, and its contacts as they are now.
	void step(double h, const ist::Wrench& pull, LinearContact* touching, int count, const WorldSnapshot& world) noexcept;

	LocalTool tool;
	struct Body
	{
		SpentImpulse spent;     ///< X_WB and twist are the copy's own
		double share = 0;       ///< of the contact with the tool that counts; a contact that begins inside fades in
		ist::Vec3 shift, turn;  ///< still to be put right
		double left = 0;        ///< time for that [s]
	};
	Body& body(int slot) noexcept { return m_bodies[slot]; }
	const Body& body(int slot) const noexcept { return m_bodies[slot]; }
	/// That the last step put on the tool in the contact `touching[i]`, about its point, World [N s, N m s].
	const ist::Wrench& impulse(int i) const noexcept { return m_impulses[i]; }
	/// Whether the last step left the tool a twist that was not finite; it was set to zero.
	bool toolIsBroken() const noexcept { return m_toolIsBroken; }
	/// All that the tool has given, and that contacts have given to it [N s].
	const ist::Vec3& given() const noexcept { return m_given; }

private:
	static constexpr int kToolIndex = kMirroredBodies, kFixedIndex = kMirroredBodies + 1, kIndices = kMirroredBodies + 2;
	static constexpr int kRows = kMirroredContacts + kToolContacts;
	static constexpr int kSweeps = 12;        // at most
	static constexpr double kSettled = 1e-5;  // share of any row's impulse that a sweep may still change and be the last
	// What it may change besides, of rows that carry next to nothing: at 1 kHz a micronewton, and that on an arm of a centimetre [N s, N m
	// s].
	static constexpr double kSettledForce = 1e-9, kSettledTorque = 1e-11;

	static int indexOf(int slotOrTool) noexcept;
	ist::Pose putRight(int slot) const noexcept;
	void accelerate(double h, const ist::Wrench& pull, const WorldSnapshot& world) noexcept;
	void addRow(const LinearContact& contact, double h) noexcept;
	static bool isSettled(const ist::Wrench& change, const ist::Wrench& whole) noexcept;
	void solve() noexcept;
	void kick(int index, const ist::Vec3& point, const ist::Wrench& impulse) noexcept;
	ist::Twist twistAt(int index, const ist::Vec3& point) const noexcept;
	void enterSpent(const LinearContact* touching, int count) noexcept;
	void move(double h, const WorldSnapshot& world) noexcept;

	Body m_bodies[kMirroredBodies];
	btVolumetricRowBody m_rowBodies[kIndices];
	ist::Twist m_twists[kIndices];
	btVolumetricRow m_rows[kRows];
	int m_rowA[kRows] = {}, m_rowB[kRows] = {};
	int m_rowCount = 0;
	ist::Wrench m_impulses[kToolContacts];
	ist::Vec3 m_given;
	bool m_toolIsBroken = false;
};
}  // namespace devicebridge
