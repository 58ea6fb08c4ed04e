// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/ContactPatches.h"

#include "BulletISTCollision/Core/Kernels/QueryKernel.h"

#include <algorithm>
#include <limits>

namespace ist
{
using kernels::PairStream;

namespace
{
constexpr uint16_t kNoPatch = 0xffff;
constexpr uint32_t kNoLabel = 0xffffffffu;
constexpr double kConeCosine = 0.70710678;
/// A component's remainder below this share of its weight founds no patch of its own.
constexpr double kLeastShare = 0.05;
}  // namespace

void PatchGrouper::reserve(size_t pairs, size_t balls, int patches)
{
	m_patches.reserve(size_t(patches));
	if (m_open.size() < pairs)
	{
		m_open.resize(pairs);
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

void PatchGrouper::connect(const PairStream& pairs, int count, uint32_t offsetB)
{
	// Only balls that occur are initialised: the cost follows the pairs, not the trees.
	for (int i = 0; i < count; ++i)
		for (const uint32_t ball : {pairs.a[i], pairs.b[i] + offsetB})
		{
			m_parent[ball] = ball;
			m_label[ball] = kNoLabel;
		}
	for (int i = 0; i < count; ++i)
	{
		const uint32_t a = find(pairs.a[i]), b = find(pairs.b[i] + offsetB);
		// The smaller index becomes the root: with path halving this stays near linear.
		if (a < b)
			m_parent[b] = a;
		else
			m_parent[a] = b;
	}
	m_componentCount = 0;
	for (int i = 0; i < count; ++i)
	{
		// Neighbours in the list often share the ball.
		if (i > 0 && pairs.a[i] == pairs.a[i - 1])
		{
			m_componentOf[i] = m_componentOf[i - 1];
			continue;
		}
		uint32_t& label = m_label[find(pairs.a[i])];
		if (label == kNoLabel)
		{
			label = m_componentCount++;
			m_components[label] = {};
		}
		m_componentOf[i] = label;
	}
}

void PatchGrouper::measure(const PairStream& pairs, int count)
{
	m_openCount = size_t(count);
	for (int i = 0; i < count; ++i)
	{
		m_components[m_componentOf[i]].weight += pairs.weight[i];
		m_patch[i] = kNoPatch;
		m_open[i] = uint32_t(i);
	}
	for (uint32_t c = 0; c < m_componentCount; ++c) m_components[c].left = m_components[c].weight;
}

/// Founds a patch at the strongest free pair of the component with the most weight left. False when little is left.
bool PatchGrouper::seedPatch(const PairStream& pairs)
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
	float strongest = 0;
	for (size_t k = 0; k < m_openCount; ++k)
	{
		const uint32_t i = m_open[k];
		if (m_componentOf[i] != best || !(pairs.size[i] > strongest)) continue;
		seed = int(i);
		strongest = pairs.size[i];
	}
	if (seed < 0 && component.hasPatch)
	{
		component.left = 0;
		return true;
	}

	const uint16_t index = uint16_t(m_patches.size());
	Patch patch;
	patch.component = best;
	const int at = std::max(seed, 0);
	const float ax = pairs.fx[at], ay = pairs.fy[at], az = pairs.fz[at], cone = float(kConeCosine) * strongest;
	size_t open = 0;
	for (size_t k = 0; k < m_openCount; ++k)
	{
		const uint32_t i = m_open[k];
		const float along = pairs.fx[i] * ax + pairs.fy[i] * ay + pairs.fz[i] * az;
		// Without any direction in the component all its pairs belong together.
		const bool inCone = seed < 0 || int(i) == seed || (pairs.size[i] > 0 && along >= cone * pairs.size[i]);
		if (!(inCone && m_componentOf[i] == best))
		{
			m_open[open++] = i;
			continue;
		}
		m_patch[i] = index;
		patch.force += {pairs.fx[i], pairs.fy[i], pairs.fz[i]};
		patch.moment += Vec3{pairs.cx[i], pairs.cy[i], pairs.cz[i]} * double(pairs.weight[i]);
		patch.weight += pairs.weight[i];
	}
	m_openCount = open;
	patch.direction = normalized(patch.force);
	patch.center = patch.weight > 0 ? patch.moment / patch.weight : Vec3{pairs.cx[at], pairs.cy[at], pairs.cz[at]};
	component.left = std::max(0.0, component.left - patch.weight);
	component.hasPatch = true;
	m_patches.push_back(patch);
	return true;
}

void PatchGrouper::assignRest(const PairStream& pairs)
{
	double size = 0;
	for (const Patch& patch : m_patches) size = std::max(size, distance(patch.center, m_patches[0].center));
	const double perLength = size > 0 ? 1 / size : 0;
	for (size_t k = 0; k < m_openCount; ++k)
	{
		const uint32_t i = m_open[k];
		const Vec3 force{pairs.fx[i], pairs.fy[i], pairs.fz[i]}, center{pairs.cx[i], pairs.cy[i], pairs.cz[i]};
		const uint32_t own = m_componentOf[i];
		const bool stay = m_components[own].hasPatch;
		double best = -std::numeric_limits<double>::infinity();
		for (size_t p = 0; p < m_patches.size(); ++p)
		{
			const Patch& patch = m_patches[p];
			if (stay && patch.component != own) continue;
			double score = -distance(patch.center, center) * perLength;
			if (pairs.size[i] > 0) score += dot(patch.direction, force) / pairs.size[i];
			if (score <= best) continue;
			best = score;
			m_patch[i] = uint16_t(p);
		}
		// Only a score that is not finite leaves the pair without a patch.
		if (m_patch[i] == kNoPatch) m_patch[i] = 0;
	}
}

int PatchGrouper::group(const PairStream& pairs, int count, uint32_t ballsA, int maxPatches)
{
	m_patches.clear();
	if (count == 0) return 0;
	connect(pairs, count, ballsA);
	measure(pairs, count);
	while (int(m_patches.size()) < maxPatches && seedPatch(pairs))
	{
	}
	assignRest(pairs);
	return int(m_patches.size());
}
}  // namespace ist
