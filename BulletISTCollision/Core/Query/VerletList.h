// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>

namespace ist
{
/// Verlet list of two bodies: the pairs of balls that come within a margin of each other. While the bodies move little, it replaces the
/// search for pairs. It is valid until a point of B has moved by more than the margin, seen from A. Use one list for each pair of
/// bodies, in one query at a time.
///
/// A query with the list finds the same pairs as one without it. The sums agree to within the rounding of floats, because
/// their order differs. The division into patches may be older. A query that did not search reports no `nodeVisits`. A query with a
/// budget ignores the list, and so does one in which two levels share the answer. The list holds the pairs of one level, so a traversal
/// of another level by `queryWithTolerance` fills it anew. Only the constructor allocates.
///
/// The list also remembers the patch of each pair, from the last query that grouped the pairs. A pair that begins to touch later joins
/// a patch of one of its balls, or the nearest patch. So a query that does not search needs neither a list of intersecting pairs nor a
/// grouping. The pairs are grouped anew when the number of intersecting pairs changes by 10 %, or when normals within the patches
/// cancel by 10 % more.
///
/// The list is filled around a pose extrapolated from recent motion, and so lasts twice as long. The margin follows that motion, too.
/// When bodies move so fast that a list saves nothing, each query searches anew. A query that fills the list costs as much as 1.5 to 3
/// queries without it.
class VerletList
{
public:
	/// `pairs`: capacity, at 17 bytes per pair. While more than 80 % of it intersect, each query searches anew.
	explicit VerletList(int pairs = 200000);
	~VerletList();
	VerletList(VerletList&&) noexcept;
	VerletList& operator=(VerletList&&) noexcept;

	/// Call this before a tree of the bodies is replaced by another one at the same address. Queries detect any other change.
	void forget();

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};

using PairMemory [[deprecated("since 0.3: VerletList")]] = VerletList;
}  // namespace ist
