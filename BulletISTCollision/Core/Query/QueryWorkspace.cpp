// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"

#include <algorithm>
#include <utility>

namespace ist
{
using namespace kernels;

namespace
{
/// Capacity of each of the two lists of faces.
constexpr int kFewestFaces = 4096, kMostFaces = 32768;
/// Number of terms of closed forms that makeResident() covers, 5 MB. A query with more takes longer than a tick of 1 ms anyway.
constexpr size_t kResidentTerms = 32768;

const QueryKernel* kernelFor(InstructionSet set)
{
	if (!isAvailable(set)) return nullptr;
	switch (set)
	{
#if defined(__x86_64__)
	case InstructionSet::Baseline: return &kBaselineKernel;
	case InstructionSet::V3: return &kV3Kernel;
	case InstructionSet::V4: return &kV4Kernel;
#elif defined(__aarch64__)
	case InstructionSet::Neon: return &kNeonKernel;
#endif
	default: return &kPortableKernel;
	}
}

const QueryKernel* chosenKernel()
{
	const Result<InstructionSet> set = chosenInstructionSet();
	return set ? kernelFor(set.value()) : nullptr;
}
}  // namespace

QueryWorkspace::Implementation::Implementation(const QueryCapacity& wanted, const QueryKernel* chosen) : kernel(chosen), capacity(wanted)
{
	capacity.pairs = std::max(1, capacity.pairs);
	capacity.patches = std::clamp(capacity.patches, 1, 1024);
	capacity.listEntries = std::max(kLeastListEntries, capacity.listEntries);
	openBatch = std::min(kOpenBatch, capacity.listEntries / kLeastListEntries);

	const size_t open = size_t(capacity.listEntries) + kListSlack, found = size_t(capacity.pairs) + kPairBatch + kListSlack;
	const size_t batch = kPairBatch + kListSlack;
	indices = DemandZeroArray<uint32_t>(4 * open + 2 * kLeafEntries + 2 * kBallEntries + 2 * batch + 2 * found);
	numbers = DemandZeroArray<float>(8 * open + 4 * kLeafEntries + PairStream::ColumnCount * found);
	uint32_t* index = indices.data();
	float* number = numbers.data();
	const auto column = [](auto*& next, size_t size) { return next += size, next - size; };
	const auto list = [&](size_t size) {
		uint32_t *a = column(index, size), *b = column(index, size);
		float *x = column(number, size), *y = column(number, size), *z = column(number, size), *r = column(number, size);
		return SubtreeList{a, b, x, y, z, r, 0};
	};
	openA = list(open);
	openB = list(open);
	leaves = list(kLeafEntries);
	ballOf = column(index, kBallEntries);
	blockOf = column(index, kBallEntries);
	pairA = column(index, batch);
	pairB = column(index, batch);
	stream.a = column(index, found);
	stream.b = column(index, found);
	stream.numbers = column(number, PairStream::ColumnCount * found);
	stream.stride = found;
	terms.reserve(size_t(capacity.pairs));  // costs no memory for pages that no query fills
	patches.resize(size_t(capacity.patches));
	savedPatches.resize(patches.size());
	surfaces = std::make_unique<SurfaceWorkspace>(
		size_t(std::clamp(capacity.pairs / 6, kFewestFaces, kMostFaces)), capacity.patches, kernel);
	grouper.reserve(size_t(capacity.pairs), 0, capacity.patches);
}

void TreeArrays::reserveSlots(size_t slotsA, size_t slotsB, size_t ellipsoidsB)
{
	const size_t blocksA = slotsA / kBlockWidth, blocksB = slotsB / kBlockWidth;
	if (columnsA.size() < blocksA)
	{
		columnsA.resize(blocksA);
		epochsA.resize(blocksA);
	}
	if (moved.size() < blocksB)
	{
		moved.resize(blocksB);
		marks.resize(blocksB);
		movedCenters.resize(slotsB);
	}
	if (movedBalls.size() < ellipsoidsB) movedBalls.resize(ellipsoidsB);
}

void TreeArrays::takeLarger(TreeArrays& other) noexcept
{
	const auto take = [](auto& mine, auto& theirs) {
		if (mine.size() < theirs.size()) mine.swap(theirs);
	};
	take(columnsA, other.columnsA);
	take(epochsA, other.epochsA);
	take(moved, other.moved);
	take(marks, other.marks);
	take(movedCenters, other.movedCenters);
	take(movedBalls, other.movedBalls);
}

void QueryWorkspace::Implementation::reserveFor(const BallTree& A, const BallTree& B)
{
	reserveSlots(A.slotCount(), B.slotCount(), B.ellipsoids.size());
	grouper.reserve(size_t(capacity.pairs), A.slotCount() + B.slotCount(), capacity.patches);
	if (++epoch == 0)
	{
		std::fill(epochsA.begin(), epochsA.end(), 0u);
		for (BlockMark& mark : marks) mark.epoch = 0;
		epoch = 1;
	}
}

void QueryWorkspace::Implementation::reserveTerms(const BallTree& A)
{
	terms.clear();
	grouper.reserve(size_t(capacity.pairs), A.slotCount() + 1, capacity.patches);
}

void QueryWorkspace::Implementation::reservePairs()
{
	if (!pairs.empty()) return;
	pairs.resize(size_t(capacity.pairs));
	savedPairs.resize(pairs.size());
	keys.resize(size_t(capacity.pairs));
}

QueryWorkspace::QueryWorkspace(const QueryCapacity& capacity) : m_impl(std::make_unique<Implementation>(capacity, chosenKernel())) {}
QueryWorkspace::QueryWorkspace(const QueryCapacity& capacity, InstructionSet set)
	: m_impl(std::make_unique<Implementation>(capacity, kernelFor(set)))
{}
QueryWorkspace::~QueryWorkspace() = default;
QueryWorkspace::QueryWorkspace(QueryWorkspace&&) noexcept = default;
QueryWorkspace& QueryWorkspace::operator=(QueryWorkspace&&) noexcept = default;
const QueryCapacity& QueryWorkspace::capacity() const { return m_impl->capacity; }

void QueryWorkspace::reserve(const InnerSphereTree& A, const InnerSphereTree& B)
{
	const size_t slotsA = mostSlots(A), slotsB = mostSlots(B);
	m_impl->reserveSlots(slotsA, slotsB, slotsB);
	m_impl->grouper.reserve(size_t(m_impl->capacity.pairs), slotsA + slotsB, m_impl->capacity.patches);
}

void QueryWorkspace::Implementation::makeResident()
{
	indices.touch();
	numbers.touch();
	// Queries against curved closed forms fill this list.
	touchPages(terms.data(), std::min(terms.capacity(), kResidentTerms) * sizeof(FieldTerm));
	grouper.makeResident();
	surfaces->makeResident();
}

void QueryWorkspace::makeResident() { m_impl->makeResident(); }

void QueryWorkspace::take(QueryBuffers& room) noexcept
{
	QueryBuffers::Implementation& from = room.implementation();
	if (std::exchange(from.taken, true)) return;
	m_impl->takeLarger(from);
	m_impl->grouper.takeLarger(from.balls);
}

QueryBuffers::QueryBuffers(const InnerSphereTree& A, const InnerSphereTree& B) : m_impl(std::make_unique<Implementation>())
{
	const size_t slotsA = mostSlots(A), slotsB = mostSlots(B);
	m_impl->reserveSlots(slotsA, slotsB, slotsB);
	m_impl->balls.reserve(slotsA + slotsB);
}
QueryBuffers::~QueryBuffers() = default;

size_t mostSlots(const InnerSphereTree& body)
{
	size_t most = body.law.slotCount();
	for (const BallTree& level : body.levels) most = std::max(most, level.slotCount());
	return most;
}
}  // namespace ist
