// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

#include "BulletHapticForce/Solver/btVolumetricRows.h"
#include "DeviceBridge/Loop/WorldMirror.h"

namespace devicebridge
{
/// The tool, which only the hand's thread accesses.
struct LocalTool
{
	double mass = 1;                             ///< [kg]
	ist::Mat3 inverseInertia = ist::zeroMat3();  ///< axes of T [1/(kg m^2)]
	ist::Vec3 gravity;                           ///< World [m/s^2]
	ToolState state;                             ///< state of the tool in World
};

/// The hand's own copy of the bodies near the tool, valid from one step of the world to the next and a little longer. The copies move under
/// gravity, under the tool, and on their supports, which are linear models of the world's contacts. The copies are solved with the same
/// implicit rows as the world. So a light body yields to the tool within a tick, as it would not under the impulse of a whole step of the
/// world. The impulses of the tool on a copy are summed, and the world gets exactly that sum.
///
/// When the world has taken a step, its body is compared with the copy as the world knew it, and the difference is corrected. The velocity
/// is corrected at once and the pose over one period, so that no contact jumps. Each correction is made once, however long the step took:
/// what was corrected since counts, and so does what the copy's own supports have done since.
///
/// Why this is passive: let J be the impulse sum of a period. The tool's work on a free copy is J.(u0 + J/2m), with u0 its velocity when
/// the world was published. The world applies J to the body at exactly that velocity: the same energy. The supports of the body can only
/// remove energy. Only the correction of a pose can do work on the tool; the device's passivity controller covers that. One thread, no
/// allocation.
class BulletLocalWorld
{
public:
	/// `slots` is that of the snapshots.
	explicit BulletLocalWorld(int slots = kMirroredBodies);

	static constexpr double kComparedPeriods = 2;  ///< age of the copy as the world knew it up to which it is compared, in periods
	static constexpr double kTeleport = 0.05;  ///< pose error above which a copy is corrected at once, and its contact fades in again [m]

	/// Corrects the copies by a new snapshot.
	void reconcile(const WorldSnapshot& world) noexcept;
	/// Sets whether the world is so late that no contact has weight. Then the copies stand still, but for the rest of a correction, and the
	/// next snapshot places them where their bodies are. Call it before each step().
	void hold(bool held) noexcept;
	/// Takes one step of `h` [s] with `pull` on the tool about its centre, and with the present contacts `touching`.
	void step(double h, const ist::Wrench& pull, LinearContact* touching, int count, const WorldSnapshot& world) noexcept;

	LocalTool tool;
	struct Body
	{
		SpentImpulse spent;     ///< X_WB and twist are the copy's own
		double share = 0;       ///< weight of the contact with the tool; a contact that begins inside fades in
		ist::Vec3 shift, turn;  ///< remaining correction of the pose [m, rad]
		double left = 0;        ///< remaining time for it [s]
	};
	Body& body(int slot) noexcept { return m_bodies[std::size_t(slot)]; }
	const Body& body(int slot) const noexcept { return m_bodies[std::size_t(slot)]; }
	/// Impulse on the tool in the last step from the contact `touching[i]`, about the contact's point, World [N s, N m s].
	const ist::Wrench& impulse(int i) const noexcept { return m_impulses[std::size_t(i)]; }
	/// Whether the last step gave the tool a twist that is not finite; the twist was then set to zero.
	bool toolIsBroken() const noexcept { return m_toolIsBroken; }
	/// Sum of the impulses that contacts have given to the tool [N s].
	const ist::Vec3& given() const noexcept { return m_given; }

private:
	static constexpr int kSweeps = 12;        // largest number of sweeps
	static constexpr double kSettled = 1e-5;  // largest change in the last sweep, as a share of each row's impulse
	// Absolute part of that limit, for rows with almost no impulse [N s, N m s]. At 1 kHz it is a micronewton, with a lever of a
	// centimetre.
	static constexpr double kSettledForce = 1e-9, kSettledTorque = 1e-11;

	/// A slot, the tool, or everything that is fixed, in the arrays below.
	struct Place
	{
		btVolumetricRowBody body;
		ist::Twist twist;
		bool moves = false, stands = false;  ///< a body that others move is neither
	};
	struct Row
	{
		btVolumetricRow row;
		std::size_t a = 0, b = 0;  ///< places
	};

	void correct(Body& body, const MirroredBody& now, double period) const noexcept;
	std::size_t placeOf(int slotOrTool) const noexcept;
	Place& toolPlace() noexcept { return m_places[m_bodies.size()]; }
	ist::Pose putRight(int slot) const noexcept;
	void accelerate(double h, const ist::Wrench& pull, const WorldSnapshot& world) noexcept;
	void addRow(const LinearContact& contact, double h) noexcept;
	static bool isSettled(const ist::Wrench& change, const ist::Wrench& whole) noexcept;
	void solve() noexcept;
	static void kick(Place& place, const ist::Vec3& point, const ist::Wrench& impulse) noexcept;
	static ist::Twist twistAt(const Place& place, const ist::Vec3& point) noexcept;
	void enterSpent(const LinearContact* touching, int count) noexcept;
	void move(double h, const WorldSnapshot& world) noexcept;

	std::vector<Body> m_bodies;
	std::vector<Place> m_places;  // the slots, then the tool, then what is fixed
	std::vector<Row> m_rows;
	std::size_t m_rowCount = 0;
	std::vector<ist::Wrench> m_impulses;
	ist::Vec3 m_given;
	bool m_toolIsBroken = false;
	bool m_held = false;
};
}  // namespace devicebridge
