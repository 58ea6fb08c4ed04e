// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>

namespace ist
{
/// Verlet list of two bodies: the pairs of balls that come within a margin of each other. It spares bodies that move little the search
/// for pairs. It is valid until a point of B has moved by more than the margin, seen from A. Use one for each pair of bodies, in one
/// query at a time.
///
/// A query with the list finds the same pairs as one without it. The sums agree to the rounding of floats, whose order differs; the
/// division into patches may be older. A query that did not search reports no `nodeVisits`. The list is not used within budgets, nor
/// while two levels share an answer. It holds the pairs of one level, so a traversal of another level by `queryWithTolerance` fills it
/// anew. Only the constructor allocates.
///
/// The list also remembers the patch of each pair, from the last query that grouped the pairs. A pair that begins to touch later joins
/// a patch of one of its balls, or the nearest patch. So a query that does not search needs neither a list of intersecting pairs nor a
/// grouping. The pairs are grouped anew when the number of intersecting pairs changes by 10 %, or when normals within the patches
/// cancel by 10 % more.
///
/// The list is filled around a pose extrapolated from recent motion, and so lasts twice as long. The margin follows that motion, too.
/// When bodies move too fast for the list to pay, each query searches anew. A query that fills the list costs as much as 1.5 to 3
/// queries without it.
class VerletList
{
public:
	/// `pairs`: capacity, at 17 bytes per pair. While more than 80 % of it intersect, each query searches anew.
	explicit VerletList(int pairs = 200000);
	~VerletList();
	VerletList(VerletList&&) noexcept;
	VerletList& operator=(VerletList&&) noexcept;

	/// Call this before a tree of the bodies is replaced by another one at the same address. Queries notice any other change.
	void forget();

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};

using PairMemory [[deprecated("since 0.3: VerletList")]] = VerletList;
}  // namespace ist
