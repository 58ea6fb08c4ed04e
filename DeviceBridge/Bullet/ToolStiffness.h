// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

#include "DeviceBridge/Loop/WorldMirror.h"

namespace devicebridge
{
class BulletLocalWorld;

/// Stiffness of the tool's contacts where none was set. It follows what presses, as in the world (stiffnessUnder), for each pair of parts,
/// relative to the stiffness with which the contacts were found. Without this a tool sinks into a body that bears only its own weight.
/// Contacts must be found anew in each tick: a linear model of a stiff and shallow contact is wrong as soon as the tool moves.
/// One thread. It allocates in the constructor only.
class ToolStiffness
{
public:
	explicit ToolStiffness(int slots);

	/// Forgets what has pressed.
	void forget() noexcept { m_count = 0; }
	/// Takes the pairs of a new snapshot. Pairs that were known keep what has pressed on them. O(pairs^2), and O(pairs) where they are
	/// those of the snapshot before.
	void take(const WorldSnapshot& world) noexcept;
	/// Stiffens the contacts of a tick of `h` [s]. `toolMass`: [kg].
	void stiffen(LinearContact* touching, int count, const WorldSnapshot& world, double toolMass, double h) noexcept;
	/// Notes what pressed in the tick. `local` has the impulses of these contacts.
	void note(const LinearContact* touching, int count, const BulletLocalWorld& local, double h) noexcept;

private:
	struct Pair
	{
		std::uint64_t epoch = 0;  // of the body in the slot
		int slot = 0, toolPart = 0, bodyPart = 0;
		double factor = 0;     // of the stiffness, in the last tick; 0: the parts did not touch
		ist::Vec3 pressed;     // mean of the normal force on the tool lately [N]
		ist::Vec3 impulse;     // of the normal forces of this tick [N s]
		double force = 0;      // sum of the elastic forces as they were found [N]
		double stiffness = 0;  // sum of their stiffnesses along the normals [N/m]
		double aimed = 0;      // LinearContact::restDepth
	};
	static bool isSame(const Pair& a, const Pair& b) noexcept;
	/// Lets the factor follow what presses.
	static void follow(Pair& pair, double mass, double h) noexcept;

	std::vector<Pair> m_pairs, m_next;
	int m_count = 0;
};
}  // namespace devicebridge
