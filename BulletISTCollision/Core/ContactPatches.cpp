// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/ContactPatches.h"

#include <algorithm>
#include <limits>

namespace ist
{
namespace
{
constexpr uint16_t kNoPatch = 0xffff;
constexpr uint32_t kNoLabel = 0xffffffffu;
constexpr double kConeCosine = 0.70710678;
/// A component's remainder below this share of its weight founds no patch of its own.
constexpr double kLeastShare = 0.05;
/// Pairs whose normals cancel to less than this share of dd L have no direction.
constexpr float kWeakNormal = 0.1f;
}  // namespace

void PatchGrouper::reserve(size_t pairs, size_t balls)
{
	if (m_force.size() < pairs)
	{
		m_force.resize(pairs);
		m_componentOf.resize(pairs);
		m_patch.resize(pairs);
		m_components.resize(pairs);
	}
	if (m_parent.size() < balls)
	{
		m_parent.resize(balls);
		m_label.resize(balls);
	}
}

uint32_t PatchGrouper::find(uint32_t ball)
{
	while (m_parent[ball] != ball)
	{
		m_parent[ball] = m_parent[m_parent[ball]];
		ball = m_parent[ball];
	}
	return ball;
}

void PatchGrouper::connect(const OverlapPair* pairs, int count, uint32_t offsetB)
{
	// Only balls that occur are initialised: the cost follows the pairs, not the trees.
	for (int i = 0; i < count; ++i)
		for (const uint32_t ball : {pairs[i].ballA, pairs[i].ballB + offsetB})
		{
			m_parent[ball] = ball;
			m_label[ball] = kNoLabel;
		}
	for (int i = 0; i < count; ++i)
	{
		const uint32_t a = find(pairs[i].ballA), b = find(pairs[i].ballB + offsetB);
		// The smaller index becomes the root: with path halving this stays near linear.
		if (a < b)
			m_parent[b] = a;
		else
			m_parent[a] = b;
	}
	m_componentCount = 0;
	for (int i = 0; i < count; ++i)
	{
		uint32_t& label = m_label[find(pairs[i].ballA)];
		if (label == kNoLabel)
		{
			label = m_componentCount++;
			m_components[label] = {};
		}
		m_componentOf[i] = label;
	}
}

void PatchGrouper::measure(const OverlapPair* pairs, int count, const BallTree& A, const BallTree& B, const Mat3& R)
{
	for (int i = 0; i < count; ++i)
	{
		const MomentBall& a = A.balls[pairs[i].ballA];
		const MomentBall& b = B.balls[pairs[i].ballB];
		const double mass = double(a.density) * b.density * pairs[i].lens;
		const Vec3 force = (R * b.normal() - a.normal()) * mass;
		const double size = norm(force);
		const bool weak = size < kWeakNormal * mass;
		m_force[i] = {float(force.x), float(force.y), float(force.z), weak ? 0.0f : float(size),
					  float(std::max(size, 1e-3 * mass))};
		m_patch[i] = kNoPatch;
		Component& component = m_components[m_componentOf[i]];
		component.weight += m_force[i].weight;
		component.left += m_force[i].weight;
	}
}

/// Founds a patch at the strongest free pair of the component with the most weight left. False when little is left.
bool PatchGrouper::seedPatch(const OverlapPair* pairs, int count)
{
	uint32_t best = kNoLabel;
	for (uint32_t c = 0; c < m_componentCount; ++c)
	{
		const Component& component = m_components[c];
		if (component.hasPatch && component.left <= kLeastShare * component.weight) continue;
		if (best == kNoLabel || component.left > m_components[best].left) best = c;
	}
	if (best == kNoLabel) return false;
	Component& component = m_components[best];

	int seed = -1;
	for (int i = 0; i < count; ++i)
		if (m_componentOf[i] == best && m_patch[i] == kNoPatch && m_force[i].size > 0 &&
			(seed < 0 || m_force[i].size > m_force[seed].size))
			seed = i;
	if (seed < 0 && component.hasPatch)
	{
		component.left = 0;
		return true;
	}

	const uint16_t index = uint16_t(m_patches.size());
	Patch patch;
	patch.component = best;
	const Force axis = seed >= 0 ? m_force[seed] : Force{};
	for (int i = 0; i < count; ++i)
	{
		if (m_componentOf[i] != best || m_patch[i] != kNoPatch) continue;
		const Force& f = m_force[i];
		const double along = double(f.x) * axis.x + double(f.y) * axis.y + double(f.z) * axis.z;
		// Without any direction in the component all its pairs belong together.
		if (seed >= 0 && i != seed && !(f.size > 0 && along >= kConeCosine * f.size * axis.size)) continue;
		m_patch[i] = index;
		patch.force += {f.x, f.y, f.z};
		patch.moment += pairs[i].centroid * double(f.weight);
		patch.weight += f.weight;
	}
	patch.direction = normalized(patch.force);
	patch.center = patch.weight > 0 ? patch.moment / patch.weight : pairs[seed >= 0 ? seed : 0].centroid;
	component.left = std::max(0.0, component.left - patch.weight);
	component.hasPatch = true;
	m_patches.push_back(patch);
	return true;
}

void PatchGrouper::assignRest(const OverlapPair* pairs, int count)
{
	double size = 0;
	for (const Patch& patch : m_patches) size = std::max(size, distance(patch.center, m_patches[0].center));
	const double perLength = size > 0 ? 1 / size : 0;
	for (int i = 0; i < count; ++i)
	{
		if (m_patch[i] != kNoPatch) continue;
		const Force& f = m_force[i];
		const uint32_t own = m_componentOf[i];
		const bool stay = m_components[own].hasPatch;
		double best = -std::numeric_limits<double>::infinity();
		for (size_t p = 0; p < m_patches.size(); ++p)
		{
			const Patch& patch = m_patches[p];
			if (stay && patch.component != own) continue;
			double score = -distance(patch.center, pairs[i].centroid) * perLength;
			if (f.size > 0) score += dot(patch.direction, {f.x, f.y, f.z}) / f.size;
			if (score <= best) continue;
			best = score;
			m_patch[i] = uint16_t(p);
		}
		// Only a score that is not finite leaves the pair without a patch.
		if (m_patch[i] == kNoPatch) m_patch[i] = 0;
	}
}

int PatchGrouper::group(const OverlapPair* pairs, int count, const BallTree& A, const BallTree& B, const Mat3& R,
						int maxPatches)
{
	m_patches.clear();
	if (count == 0) return 0;
	if (m_patches.capacity() < size_t(maxPatches)) m_patches.reserve(size_t(maxPatches));
	connect(pairs, count, uint32_t(A.balls.size()));
	measure(pairs, count, A, B, R);
	while (int(m_patches.size()) < maxPatches && seedPatch(pairs, count))
	{
	}
	assignRest(pairs, count);
	return int(m_patches.size());
}
}  // namespace ist
