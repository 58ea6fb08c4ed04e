// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/WorldMirror.h"

#include <algorithm>
#include <utility>

namespace devicebridge
{
WorldMirror::WorldMirror(int slots)
	: m_slots(slots),
	  m_snapshots(slots),
	  m_posts(slots),
	  m_bodies(std::size_t(slots)),
	  m_trees(std::size_t(slots)),
	  m_taken(std::size_t(slots))
{}

void WorldMirror::collect() noexcept
{
	m_posts.fetch();
	for (std::size_t slot = 0; slot < m_bodies.size(); ++slot)
	{
		MirroredBody& body = m_bodies[slot];
		Taken& taken = m_taken[slot];
		taken = {};
		const SpentImpulse& now = posted().bodies[slot];
		if (body.epoch == 0 || now.epoch != body.epoch) continue;
		const SpentImpulse before = body.seen.epoch == body.epoch ? body.seen : SpentImpulse();
		taken.impulse = now.impulse - before.impulse;
		taken.seconds = now.seconds - before.seconds;
		// An impulse moves the body only in the time after it was given.
		const ist::Wrench carried = now.area - before.area - taken.seconds * before.impulse;
		const double along = dot(carried.force, taken.impulse.force), all = taken.seconds * squaredNorm(taken.impulse.force);
		taken.share = all > 0 ? std::clamp(1 - along / all, 0.0, 1.0) : 0;
		body.seen = now;
	}
}

int WorldMirror::find(const void* id) const noexcept
{
	for (std::size_t slot = 0; slot < m_bodies.size(); ++slot)
		if (m_bodies[slot].epoch != 0 && m_bodies[slot].id == id) return int(slot);
	return -1;
}

int WorldMirror::admit(const void* id, Trees trees) noexcept
{
	for (std::size_t slot = 0; slot < m_bodies.size(); ++slot)
	{
		if (m_bodies[slot].epoch != 0) continue;
		m_bodies[slot] = {};
		m_bodies[slot].epoch = ++m_epochs;
		m_bodies[slot].id = id;
		m_trees[slot] = std::move(trees);
		return int(slot);
	}
	return -1;
}

bool WorldMirror::releaseIfDone(int slot) noexcept
{
	MirroredBody& tenant = body(slot);
	const bool done = tenant.leaving && tenant.seen.epoch == tenant.epoch && tenant.seen.released;
	if (done) tenant = {}, m_trees[std::size_t(slot)].clear();
	return done;
}

void WorldMirror::leaveAll() noexcept
{
	for (MirroredBody& body : m_bodies)
		if (body.epoch != 0) body.leaving = true, body.id = nullptr;
}

void WorldMirror::clear() noexcept
{
	std::fill(m_bodies.begin(), m_bodies.end(), MirroredBody());
	writable().pairCount = writable().contactCount = writable().toolContactCount = 0;
	publish(writable().period);
	for (Trees& trees : m_trees) trees.clear();
}

void WorldMirror::publish(double period) noexcept
{
	WorldSnapshot& out = m_snapshots.writable();
	out.step = ++m_steps;
	out.period = period;
	std::copy(m_bodies.begin(), m_bodies.end(), out.bodies.begin());
	m_snapshots.publish();
}
}  // namespace devicebridge
