// SPDX-License-Identifier: Zlib
// The half of TreeQuery that shares a search with a helper.
#include "BulletISTCollision/Core/Kernels/QueryHelperState.h"
#include "BulletISTCollision/Core/Kernels/SteadyTime.h"

#include <algorithm>

namespace ist
{
using namespace kernels;

namespace
{
using Helper = QueryHelper::Implementation;

/// Columns that a list of subtrees and the entries that are dealt out have in common.
template <typename From, typename To>
void copyEntry(const From& from, size_t i, To& to, size_t j)
{
	to.a[j] = from.a[i];
	to.b[j] = from.b[i];
	to.x[j] = from.x[i];
	to.y[j] = from.y[i];
	to.z[j] = from.z[i];
	to.r[j] = from.r[i];
}

void append(SharedEntries& entries, const SubtreeList& list, bool openA)
{
	for (int i = 0; i < list.size; ++i)
	{
		entries.openA[size_t(entries.count)] = openA;
		copyEntry(list, size_t(i), entries, size_t(entries.count++));
	}
}

/// `count` pairs from one list to another.
void copy(const PairStream& from, int begin, int count, const PairStream& to, int at)
{
	std::copy_n(from.a + begin, count, to.a + at);
	std::copy_n(from.b + begin, count, to.b + at);
	for (int c = 0; c < PairStream::ColumnCount; ++c) std::copy_n(columnOf(from, c) + begin, count, columnOf(to, c) + at);
}
}  // namespace

void TreeQuery::searchPart(const SharedEntries& entries, int part, PartResult& result)
{
	PairSearch s = newSearch();
	m_search = &s;
	for (int i = part; i < entries.count; i += Helper::kParts)
	{
		const size_t from = size_t(i);
		SubtreeList& list = entries.openA[from] ? s.openA : s.openB;
		copyEntry(entries, from, list, size_t(list.size++));
	}
	std::fill(std::begin(m_sums), std::end(m_sums), 0.0);
	result.begin = m_listed;
	m_work.kernel->search(s);
	result.count = m_listed - result.begin;
	result.counts = s.counts;
	result.complete = m_result.pairListComplete;
	std::copy(std::begin(m_sums), std::end(m_sums), result.sums);
	m_search = nullptr;
}

bool TreeQuery::finishWith(Helper& helper, PairSearch& begun)
{
	if (begun.openA.size + begun.openB.size > SharedEntries::kMost)
	{
		begun.stopAt = 0;
		begun.counts = {};
		m_work.kernel->search(begun);
		count(begun.counts);
		return true;
	}
	helper.entries.count = 0;
	append(helper.entries, begun.openA, true);
	append(helper.entries, begun.openB, false);
	double sums[kSumCount];
	std::copy(std::begin(m_sums), std::end(m_sums), sums);
	const int listed = m_listed;
	helper.open(m_A, m_B, m_X, m_options, m_limits, m_work.kernel);
	const PartResult* parts[Helper::kParts] = {};
	const auto searchAlone = [&](int part) {
		searchPart(helper.entries, part, helper.own[part]);
		parts[part] = &helper.own[part];
	};
	double longest = 0;
	for (int part; (part = helper.claim()) < Helper::kParts;)
	{
		const double start = steadyMicroseconds();
		searchAlone(part);
		longest = std::max(longest, steadyMicroseconds() - start);
	}
	for (int part = 0; part < Helper::kParts; ++part)
	{
		if (parts[part]) continue;
		if (helper.finished(part, longest)) parts[part] = &helper.found[part];
		else searchAlone(part);
	}
	helper.close();
	std::copy(std::begin(sums), std::end(sums), m_sums);
	m_listed = listed;
	return collectParts(helper, parts);
}

bool TreeQuery::collectParts(Helper& helper, const PartResult* const* parts)
{
	const int begin = m_listed;
	bool complete = m_result.pairListComplete;
	for (int part = 0; part < Helper::kParts; ++part)
	{
		const PartResult& from = *parts[part];
		for (int i = 0; i < kSumCount; ++i) m_sums[i] += from.sums[i];
		count(from.counts);
		complete = complete && from.complete;
		m_listed += from.count;
	}
	if (!complete || m_listed > m_work.capacity.pairs) return false;
	if (m_listed == begin) return true;
	// In the order of the parts, whoever found them: by way of a list beside both.
	int to = 0;
	for (int part = 0; part < Helper::kParts; ++part)
	{
		const PartResult& from = *parts[part];
		copy(parts[part] == &helper.own[part] ? m_work.stream : helper.work.stream, from.begin, from.count, helper.sorted, to);
		to += from.count;
	}
	copy(helper.sorted, 0, to, m_work.stream, begin);
	return true;
}
}  // namespace ist
