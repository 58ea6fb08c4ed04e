// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <memory>

#include "BulletHapticForce/Law/btContactLaw.h"
#include "DeviceBridge/Loop/WorldMirror.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge
{
/// Contacts of the tool with mirrored bodies, found by queries of the trees. One thread queries. It allocates nothing for half-spaces, for
/// trees of the tool's size, and for trees that another thread passed to reserve(). In the first query of a larger tree it allocates.
class BulletToolContacts
{
public:
	/// The tool's tree must outlive this object. `maxPairs` is the budget of a query, see ist::QueryOptions; negative: no limit.
	explicit BulletToolContacts(const ist::InnerSphereTree& tool, std::int64_t maxPairs = -1);

	/// Reserves memory for queries of `tree`. One other thread may call it, before the querying thread receives a body with this tree. It
	/// allocates about 120 bytes per leaf if no larger tree came before.
	void reserve(const ist::InnerSphereTree& tree);

	// For the thread that queries:
	/// Finds the patches between the tool at X_WT and a body in slot `slot` at X_WB, with the constants of `body`. Returns their number, at
	/// most `capacity`. The tool is A. The overlap volume [m^3] is added to `volume`.
	int find(const ist::Pose& X_WT, const MirroredBody& body, const ist::Pose& X_WB, int slot, LinearContact* out, int capacity,
		double& volume) noexcept;
	/// Processor time of the queries alone [us], on the calling threads, since measure().
	double queryMicroseconds() const noexcept { return m_queryMicroseconds; }
	void measure() noexcept { m_measures = true; }
	/// Number of queries that used a coarser level than the leaves to stay within the budget.
	std::uint64_t coarsened() const noexcept { return m_coarsened; }
	/// Number of queries that exceed the budget at every level. They ran without a budget, because no force at all would be worse.
	std::uint64_t overBudget() const noexcept { return m_overBudget; }
	/// Number of queries without an answer (ist::QueryStatus), and so without a force.
	std::uint64_t refused() const noexcept { return m_refused; }

private:
	ist::OverlapResult ask(const ist::Pose& X_WT, const MirroredBody& body, const ist::Pose& X_WB) noexcept;

	const ist::InnerSphereTree& m_tool;
	ist::QueryWorkspace m_workspace;
	TripleBuffer<std::unique_ptr<ist::QueryBuffers>>
		m_buffers;                 // new buffers; fetched ones are exchanged for the workspace's own, which the thread of reserve() frees
	std::size_t m_buffersFor = 0;  // number of slots in the largest buffers so far
	std::int64_t m_maxPairs;
	btISTContact m_contact;  // pair that the contact law reads; it does not own its trees
	std::uint64_t m_coarsened = 0, m_overBudget = 0, m_refused = 0;
	bool m_measures = false;
	double m_queryMicroseconds = 0;
};

/// The linear model of `patch` between A and B at their poses.
LinearContact linearContact(const btContactPatch& patch, const ist::Pose& X_WA, const ist::Pose& X_WB) noexcept;
btContactPatch contactPatch(const LinearContact& contact) noexcept;
}  // namespace devicebridge
