// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Loop/WorldMirror.h"

#include <algorithm>
#include <utility>

namespace devicebridge
{
void WorldMirror::collect() noexcept
{
	m_posts.fetch();
	for (int slot = 0; slot < kMirroredBodies; ++slot)
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
	for (int slot = 0; slot < kMirroredBodies; ++slot)
		if (m_bodies[slot].epoch != 0 && m_bodies[slot].id == id) return slot;
	return -1;
}

int WorldMirror::admit(const void* id, std::shared_ptr<const ist::InnerSphereTree> tree) noexcept
{
	for (int slot = 0; slot < kMirroredBodies; ++slot)
	{
		if (m_bodies[slot].epoch != 0) continue;
		m_bodies[slot] = {};
		m_bodies[slot].epoch = ++m_epochs;
		m_bodies[slot].id = id;
		m_bodies[slot].tree = tree.get();
		m_trees[slot] = std::move(tree);
		return slot;
	}
	return -1;
}

bool WorldMirror::releaseIfDone(int slot) noexcept
{
	MirroredBody& body = m_bodies[slot];
	const bool done = body.leaving && body.seen.epoch == body.epoch && body.seen.released;
	if (done) body = {}, m_trees[slot] = nullptr;
	return done;
}

void WorldMirror::leaveAll() noexcept
{
	for (MirroredBody& body : m_bodies)
		if (body.epoch != 0) body.leaving = true, body.id = nullptr;
}

void WorldMirror::clear() noexcept
{
	std::fill(m_bodies, m_bodies + kMirroredBodies, MirroredBody());
	writable().contactCount = writable().toolContactCount = 0;
	publish(writable().period);
	std::fill(m_trees, m_trees + kMirroredBodies, nullptr);
}

void WorldMirror::publish(double period) noexcept
{
	WorldSnapshot& out = m_snapshots.writable();
	out.step = ++m_steps;
	out.period = period;
	std::copy(m_bodies, m_bodies + kMirroredBodies, out.bodies);
	m_snapshots.publish();
}
}  // namespace devicebridge
