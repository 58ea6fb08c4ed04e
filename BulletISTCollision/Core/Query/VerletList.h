// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>

namespace ist
{
/// What two bodies that move little from query to query need not be searched for again: the pairs that come within a margin of each other,
/// good for as long as no point of B has moved by more than the margin, seen from A. One for each pair of bodies, used by one query at a
/// time.
///
/// The answer is that of a query without it, with the same pairs: sums agree to the rounding of floats, whose order differs; how they are
/// divided into patches may be older. A query that did not search has no `nodeVisits`. Within budgets, and while two levels share an
/// answer, nothing is remembered. It holds the pairs of one level: each look of `queryWithTolerance` at another one begins it anew. No
/// allocation after the constructor.
///
/// Patches are remembered with their pairs: those of the last query that grouped them. What comes to touch since belongs to a patch of its
/// balls, or to the nearest. So a query that does not search needs no list of its pairs, and their grouping is left out, too, until a tenth
/// more or fewer pairs intersect, or normals within the patches cancel by a tenth more: then they are grouped anew.
///
/// It is filled around a pose ahead, to which the motion of late will lead, and so lasts twice as long. The margin follows that motion,
/// too; where bodies move too fast for it to pay, each query searches anew. The tick that fills the memory costs as much as one and a half
/// to three queries without.
class VerletList
{
public:
	/// `pairs`: room; while more than four fifths of it intersect, each query searches anew. Seventeen bytes each.
	explicit VerletList(int pairs = 200000);
	~VerletList();
	VerletList(VerletList&&) noexcept;
	VerletList& operator=(VerletList&&) noexcept;

	/// Call it before a tree of the bodies is replaced by another in the same place; queries notice any other change.
	void forget();

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};

using PairMemory [[deprecated("since 0.3: VerletList")]] = VerletList;
}  // namespace ist
