// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Bullet/BulletHand.h"
#include "DeviceBridge/Hand/Grasp/HeatMap.h"

#include <vector>

namespace devicebridge
{
/// Makes a heat map for an object that this hand is to touch. The parts are in the order of HandPart, with GRAB's names and labels.
std::unique_ptr<HeatMap> makeHeatMap(const HandModel& hand, ist::Mesh object);

/// Adds to a map of makeHeatMap the contacts of the hand's parts with `object`; call it after a step of `h` [s] of the world. `X_BM` is the
/// pose of the map's mesh in the object's body frame. `seconds` is the time that this step represents: `h` if every step is added. Returns
/// the sum of the parts' forces that were added [N]. No allocation.
double addTouches(HeatMap& map, const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const ist::Pose& X_BM,
	double h, double seconds) noexcept;

/// Fills a heat map with a bounded cost per step. It processes all touches of one moment over several steps and then continues with the
/// touches of a new moment. Each moment represents the time since the previous one.
class BulletHeatMapRounds
{
public:
	/// `budget` is the number of closest-point queries per step, about 0.5 us each (HeatMap::advance). The map must outlive this object,
	/// and nothing else may add to it meanwhile.
	BulletHeatMapRounds(HeatMap& map, int budget);
	/// Call it after a step, with arguments as in addTouches. It allocates only if there are more touches than ever before.
	void step(const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const ist::Pose& X_BM, double h);
	/// Processes the rest of the present moment at once. Call it before the map is read or a new grasp begins. Touches after that moment
	/// are not in the map.
	void finish();
	/// Number of moments that were begun.
	int rounds() const { return m_rounds; }
	/// Time that these moments represent [s], and the impulse of all their touches [N s].
	double seconds() const { return m_seconds; }
	double impulse() const { return m_impulse; }

private:
	struct Touch
	{
		int part;
		HeatMapContact contact;
	};
	bool work(int budget);

	HeatMap& m_map;
	int m_budget, m_rounds = 0;
	std::vector<Touch> m_touches;  ///< touches of the moment that are still to be added; the last one may have been begun
	bool m_begun = false;
	double m_since = 0, m_seconds = 0, m_impulse = 0;
};
}  // namespace devicebridge
