// SPDX-License-Identifier: Zlib
// The half of TreeQuery that shares a search with a helper.
#include "BulletISTCollision/Core/Base/SteadyTime.h"
#include "BulletISTCollision/Core/Query/QueryHelperState.h"

#include <algorithm>

namespace ist
{
using namespace kernels;

namespace
{
using Helper = QueryHelper::Implementation;

/// Columns that a list of subtrees and the entries that are dealt out have in common.
template <typename From, typename To> void copyEntry(const From& from, size_t i, To& to, size_t j)
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
	const auto searchAlone = [&](int part) {
		searchPart(helper.entries, part, helper.own);
		collectPart(helper.own, sums);
	};
	helper.open(m_A, m_B, m_X, m_options, m_limits, m_work.kernel);
	double longest = 0;
	int part = 0;
	for (; helper.claim(); ++part)
	{
		const double start = steadyMicroseconds();
		searchAlone(part);
		longest = std::max(longest, steadyMicroseconds() - start);
	}
	// The helper came from the other end: all lies in the order of the parts, whoever searched them.
	for (; part < Helper::kParts; ++part)
	{
		if (!helper.finished(part, longest)) searchAlone(part);
		else if (takeOver(helper, helper.found[part])) collectPart(helper.found[part], sums);
	}
	helper.close();
	std::copy(std::begin(sums), std::end(sums), m_sums);
	return m_result.pairListComplete;
}

/// Its pairs, to the end of the list; false: they do not all fit.
bool TreeQuery::takeOver(const Helper& helper, const PartResult& part)
{
	if (!part.complete || part.count > m_work.capacity.pairs - m_listed) return m_result.pairListComplete = false;
	copy(helper.work.stream, part.begin, part.count, m_work.stream, m_listed);
	m_listed += part.count;
	return true;
}

void TreeQuery::collectPart(const PartResult& part, double* sums)
{
	for (int i = 0; i < kSumCount; ++i) sums[i] += part.sums[i];
	count(part.counts);
}
}  // namespace ist
