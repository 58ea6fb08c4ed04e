// SPDX-License-Identifier: Zlib
#include "DeviceBridge/WorldMirror.h"

#include <algorithm>

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
		// A given impulse has carried the body for the rest of the time only.
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

int WorldMirror::admit(const void* id) noexcept
{
	for (int slot = 0; slot < kMirroredBodies; ++slot)
	{
		if (m_bodies[slot].epoch != 0) continue;
		m_bodies[slot] = {};
		m_bodies[slot].epoch = ++m_epochs;
		m_bodies[slot].id = id;
		return slot;
	}
	return -1;
}

bool WorldMirror::releaseIfDone(int slot) noexcept
{
	MirroredBody& body = m_bodies[slot];
	const bool done = body.leaving && body.seen.epoch == body.epoch && body.seen.released;
	if (done) body = {};
	return done;
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
