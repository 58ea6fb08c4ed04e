// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/ToolStiffness.h"

#include "BulletHapticForce/Law/btContactLaw.h"
#include "DeviceBridge/Bullet/BulletLocalWorld.h"

#include <algorithm>

namespace devicebridge
{
ToolStiffness::ToolStiffness(int slots) : m_pairs(std::size_t(kPairsPerSlot * slots)), m_next(m_pairs.size()) {}

bool ToolStiffness::isSame(const Pair& a, const Pair& b) noexcept
{
	return a.epoch == b.epoch && a.slot == b.slot && a.toolPart == b.toolPart && a.bodyPart == b.bodyPart;
}

void ToolStiffness::take(const WorldSnapshot& world) noexcept
{
	for (int i = 0; i < world.pairCount; ++i)
	{
		const MirroredPair& now = world.pairs[std::size_t(i)];
		Pair& pair = m_next[std::size_t(i)] = {};
		pair.epoch = world.bodies[std::size_t(now.slot)].epoch;
		pair.slot = now.slot;
		pair.toolPart = now.toolPart;
		pair.bodyPart = now.bodyPart;
		const auto begin = m_pairs.begin(), end = begin + m_count;
		const bool stays = i < m_count && isSame(begin[i], pair);
		const auto was = stays ? begin + i : std::find_if(begin, end, [&](const Pair& p) { return isSame(p, pair); });
		if (was != end) pair = *was;
	}
	m_pairs.swap(m_next);
	m_count = world.pairCount;
}

void ToolStiffness::follow(Pair& pair, double mass, double h) noexcept
{
	if (!(pair.force > 0) || !(pair.stiffness > 0) || !(pair.aimed > 0))
	{
		pair.pressed = {};
		pair.factor = 0;
		return;
	}
	// Along the normal the stiffness is k times the area, and the force is k times the volume. Here k is counted in that of the rule.
	const btPress press{norm(pair.pressed), pair.stiffness, pair.force / pair.stiffness, pair.aimed};
	const double stiffest = std::max(1.0, kStiffestPerStep * mass / (h * h * pair.stiffness));
	pair.factor = std::min(stiffnessUnder(press, 1, pair.factor, h), stiffest);
}

void ToolStiffness::stiffen(LinearContact* touching, int count, const WorldSnapshot& world, double toolMass, double h) noexcept
{
	if (!(h > 0)) return;
	for (int i = 0; i < m_count; ++i)
	{
		Pair& pair = m_pairs[std::size_t(i)];
		pair.force = pair.stiffness = pair.aimed = 0;
		pair.impulse = {};
	}
	for (int i = 0; i < count; ++i)
	{
		const LinearContact& c = touching[i];
		Pair& pair = m_pairs[std::size_t(c.pair)];
		pair.aimed = c.restDepth;
		pair.force += norm(c.wrench.force);
		for (int row = 0; row < 3; ++row)
			for (int column = 0; column < 3; ++column) pair.stiffness += c.normal[row] * c.stiffness(row, column) * c.normal[column];
	}
	for (int i = 0; i < m_count; ++i)
	{
		Pair& pair = m_pairs[std::size_t(i)];
		const ist::Vec3& inverse = world.bodies[std::size_t(pair.slot)].inverseMass;
		follow(pair, 1 / std::max({1 / toolMass, inverse.x, inverse.y, inverse.z}), h);
	}
	for (int i = 0; i < count; ++i)
		if (const double factor = m_pairs[std::size_t(touching[i].pair)].factor; factor > 0) multiply(touching[i], factor);
}

void ToolStiffness::note(const LinearContact* touching, int count, const BulletLocalWorld& local, double h) noexcept
{
	if (!(h > 0)) return;
	for (int i = 0; i < count; ++i)
	{
		const ist::Vec3& normal = touching[i].normal;
		m_pairs[std::size_t(touching[i].pair)].impulse += dot(local.impulse(i).force, normal) * normal;
	}
	for (int i = 0; i < m_count; ++i)
		if (m_pairs[std::size_t(i)].factor > 0) notePressed(m_pairs[std::size_t(i)].pressed, m_pairs[std::size_t(i)].impulse, h);
}
}  // namespace devicebridge
