// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/ContactPatches.h"

#include "BulletISTCollision/Core/Base/Vec3.h"
#include "BulletISTCollision/Core/Query/Kernels/QueryKernel.h"

#include <algorithm>
#include <limits>

namespace ist
{
using namespace kernels;

namespace
{
constexpr uint32_t kNoComponent = 0xffffffffu;
constexpr float kConeCosine = 0.70710678f;
/// Smallest share of a component's rank without a patch for which another patch is started.
constexpr double kLeastShare = 0.05;

/// Root of a ball's component. A ball that is its own parent is a root. Most roots are at most two steps away; longer paths are halved.
inline uint32_t rootOf(uint32_t* parent, uint32_t ball)
{
	uint32_t root = parent[parent[ball]];
	while (parent[root] != root) root = parent[root] = parent[parent[root]];
	return parent[ball] = root;
}
}  // namespace

void PatchGrouper::BallArrays::reserve(size_t balls)
{
	if (parent.size() >= balls) return;
	parent.resize(balls);
	label.resize(balls);
}

void PatchGrouper::reserve(size_t pairs, size_t balls, int patches)
{
	const size_t listed = pairs + kListSlack, wanted = size_t(patches);
	if (m_patches.component.size() < wanted)
	{
		m_patches.component.resize(wanted);
		for (int i = 0; i < 3; ++i)
		{
			m_patches.center[i].resize(wanted);
			m_patches.direction[i].resize(wanted);
		}
	}
	if (m_group.size() < listed)
	{
		m_group = DemandZeroArray<float>(listed);
		m_components = DemandZeroArray<Component>(listed);
	}
	m_balls.reserve(balls);
}

void PatchGrouper::makeResident()
{
	m_group.touch();
	m_components.touch();
}

/// Gives connected balls a common root, which is a ball of A.
void PatchGrouper::connect(const PairStream& pairs, int count, uint32_t offsetB)
{
	// Only balls that occur are initialised, so the cost follows the pairs and not the trees.
	uint32_t* const parent = m_balls.parent.data();
	for (int i = 0; i < count; ++i) parent[pairs.a[i]] = pairs.a[i];
	for (int i = 0; i < count; ++i) parent[pairs.b[i] + offsetB] = pairs.a[i];
	for (int i = 0; i < count; ++i)
	{
		const uint32_t a = rootOf(parent, pairs.a[i]), b = rootOf(parent, pairs.b[i] + offsetB);
		// The smaller index becomes the root; with path halving the cost stays near linear. This has no branch, because its outcome
		// would be unpredictable.
		parent[std::max(a, b)] = std::min(a, b);
	}
}

/// Numbers the components in the order of their first pairs.
void PatchGrouper::number(const PairStream& pairs, int count)
{
	constexpr GroupNumber kNone = 0;
	uint32_t* const parent = m_balls.parent.data();
	GroupNumber *const label = m_balls.label.data(), *const group = m_group.data();
	for (int i = 0; i < count; ++i) label[pairs.a[i]] = kNone;
	m_componentCount = 0;
	for (int i = 0; i < count; ++i)
	{
		const uint32_t root = rootOf(parent, pairs.a[i]);
		if (label[root] == kNone)
		{
			m_components[m_componentCount] = {};
			label[root] = -GroupNumber(++m_componentCount);
		}
		group[i] = label[root];
	}
}

/// Adds up the ranks of the pairs of each component.
void PatchGrouper::rank(const PairStream& pairs, int count)
{
	const float* const ranks = columnOf(pairs, PairStream::Rank);
	for (int i = 0; i < count; ++i) m_components[size_t(-1 - int(m_group[i]))].rank += double(ranks[i]);
	for (uint32_t c = 0; c < m_componentCount; ++c) m_components[c].left = m_components[c].rank;
}

/// Starts a patch at the strongest free pair of the component with the most rank left. Returns false when little is left.
bool PatchGrouper::seedPatch(const QueryKernel& kernel, const PairStream& pairs, int count)
{
	uint32_t best = kNoComponent;
	for (uint32_t c = 0; c < m_componentCount; ++c)
	{
		const Component& component = m_components[c];
		if (component.hasPatch && !(component.left > kLeastShare * component.rank)) continue;
		if (best == kNoComponent || component.left > m_components[best].left) best = c;
	}
	if (best == kNoComponent) return false;
	Component& component = m_components[best];

	ConeSearch search{};
	search.component = -1 - GroupNumber(best);
	search.patch = GroupNumber(m_patches.count);
	const auto force = [&](int i) { return columnOf(pairs, PairStream::Force + i); };
	if (!component.hasPatch)
	{
		search.cosine = 2;  // no pair joins
		kernel.joinCone(pairs, m_group.data(), count, search);
		component.strongest = search.strongest;
		component.rank = search.left;
	}
	const int seed = component.strongest;
	if (seed < 0 && component.hasPatch)
	{
		component.left = 0;
		return true;
	}
	// When no pair of the component has a direction, all of them belong together.
	search.all = seed < 0;
	search.cosine = kConeCosine;
	if (seed >= 0)
		for (int i = 0; i < 3; ++i) search.axis[i] = force(i)[seed] / columnOf(pairs, PairStream::Size)[seed];
	kernel.joinCone(pairs, m_group.data(), count, search);
	component.strongest = search.strongest;
	component.left = search.left;
	component.hasPatch = true;

	const Vec3 direction = normalized(Vec3{search.force[0], search.force[1], search.force[2]});
	const size_t index = m_patches.count++;
	m_patches.component[index] = search.component;
	for (int i = 0; i < 3; ++i)
	{
		m_patches.direction[i][index] = float(direction[i]);
		m_patches.center[i][index] = float(
			search.rank > 0 ? search.moment[i] / search.rank : columnOf(pairs, PairStream::Centroid + i)[std::max(seed, 0)]);
	}
	return true;
}

void PatchGrouper::assignRest(const QueryKernel& kernel, const PairStream& pairs, int count)
{
	const auto center = [&](size_t p) { return Vec3{m_patches.center[0][p], m_patches.center[1][p], m_patches.center[2][p]}; };
	double size = 0;
	for (size_t p = 0; p < m_patches.count; ++p) size = std::max(size, distance(center(p), center(0)));
	PatchList list{};
	list.component = m_patches.component.data();
	for (int i = 0; i < 3; ++i)
	{
		list.center[i] = m_patches.center[i].data();
		list.direction[i] = m_patches.direction[i].data();
	}
	list.count = int(m_patches.count);
	list.perLength = float(size > 0 ? 1 / size : 0);
	kernel.joinNearest(pairs, m_group.data(), count, list);
}

size_t PatchGrouper::nearestPatch(const Vec3& center) const
{
	size_t best = 0;
	double least = std::numeric_limits<double>::infinity();
	for (size_t p = 0; p < m_patches.count; ++p)
	{
		const double d = distance({m_patches.center[0][p], m_patches.center[1][p], m_patches.center[2][p]}, center);
		if (!(d < least)) continue;
		best = p;
		least = d;
	}
	return best;
}

void PatchGrouper::extend(const PairStream& grouped, int groupedCount, const PairIndices& all, const Sphere* ballsA, uint8_t* patchOf)
{
	// The components are no longer needed, so their array is reused.
	uint32_t* const patchOfBall = m_balls.parent.data();
	constexpr uint32_t kNone = kNoComponent;
	for (size_t i = 0; i < all.count; ++i) patchOfBall[all.a[i]] = patchOfBall[all.b[i] + all.offsetB] = kNone;
	for (int i = 0; i < groupedCount; ++i)
		patchOfBall[grouped.a[i]] = patchOfBall[grouped.b[i] + all.offsetB] = uint32_t(m_group[size_t(i)]);
	int next = 0;
	for (size_t i = 0; i < all.count; ++i)
	{
		const uint32_t a = all.a[i], b = all.b[i];
		if (next < groupedCount && grouped.a[next] == a && grouped.b[next] == b)
		{
			patchOf[i] = uint8_t(m_group[size_t(next++)]);
			continue;
		}
		const uint32_t ofA = patchOfBall[a], ofB = patchOfBall[b + all.offsetB];
		patchOf[i] = uint8_t(ofA != kNone ? ofA : ofB != kNone ? ofB : nearestPatch(ballsA[a].center()));
	}
}

int PatchGrouper::group(const QueryKernel& kernel, const PairStream& pairs, int count, uint32_t ballsA, int maxPatches)
{
	m_patches.count = 0;
	if (count == 0) return 0;
	connect(pairs, count, ballsA);
	number(pairs, count);
	if (m_componentCount > 1) rank(pairs, count);  // a single component needs no comparison
	while (int(m_patches.count) < maxPatches && seedPatch(kernel, pairs, count))
	{}
	assignRest(kernel, pairs, count);
	return int(m_patches.count);
}
}  // namespace ist
