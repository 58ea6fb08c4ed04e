// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletHand.h"
#include "DeviceBridge/Hand/Grasp/HeatMap.h"

#include <vector>

namespace devicebridge
{
/// A map for an object that this hand is to touch: parts in the order of HandPart, with GRAB's names and labels.
std::unique_ptr<HeatMap> makeHeatMap(const HandModel& hand, ist::Mesh object);

/// Into a map of makeHeatMap, after a step of `h` [s] of the world: what the parts of the hand did to `object`. `X_BM`: of the map's mesh
/// in the object's body frame. `seconds`: for how long this step stands, `h` when every step is added. Gives the force that was added, the
/// sum of the parts' [N]. No allocation.
double addTouches(HeatMap& map, const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const ist::Pose& X_BM,
	double h, double seconds) noexcept;

/// A map that takes a little of every step: all touches of one moment are worked off over as many steps as that takes, and then those of
/// another one. Each moment stands for the time since the one before.
class BulletHeatMapRounds
{
public:
	/// `looks`: closest points a step, of some 0.5 us each (HeatMap::advance). The map outlives this, and is given nothing else meanwhile.
	BulletHeatMapRounds(HeatMap& map, int looks);
	/// After a step, as addTouches. No allocation but for more touches than ever.
	void step(const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const ist::Pose& X_BM, double h);
	/// The rest of the moment in progress at once: before the map is read, or begins a new grasp. Of what came after that moment the map
	/// knows nothing.
	void finish();
	/// Moments that were begun.
	int rounds() const { return m_rounds; }
	/// For how long they stand [s], and the impulse of all their touches [N s].
	double seconds() const { return m_seconds; }
	double impulse() const { return m_impulse; }

private:
	struct Touch
	{
		int part;
		HeatMapContact contact;
	};
	bool work(int looks);

	HeatMap& m_map;
	int m_looks, m_rounds = 0;
	std::vector<Touch> m_touches;  ///< of the moment, those still to be added; the last one may have been begun
	bool m_begun = false;
	double m_since = 0, m_seconds = 0, m_impulse = 0;
};
}  // namespace devicebridge
