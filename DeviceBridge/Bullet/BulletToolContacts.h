// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <memory>

#include "BulletHapticForce/Law/btContactLaw.h"
#include "DeviceBridge/Loop/WorldMirror.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge
{
/// Contacts of the tool with mirrored bodies, by queries of the trees. One thread asks. It allocates nothing for half-spaces, for trees of
/// the tool's size and for those that another thread has made room for; at the first meeting with a larger one it makes room itself.
class BulletToolContacts
{
public:
	/// The tool's tree outlives this. `maxPairs`: budget of a query, see ist::QueryOptions; negative: none.
	explicit BulletToolContacts(const ist::InnerSphereTree& tool, std::int64_t maxPairs = -1);

	/// From one other thread, before the one that asks is told of a body with this tree. Allocates some 120 bytes a leaf where no larger
	/// tree came before.
	void reserve(const ist::InnerSphereTree& tree);

	// Thread that asks:
	/// The patches of the tool, at X_WT, and a body at X_WB, which is in `slot`, with the constants of `body`; at most `capacity`. The
	/// tool is A. The total overlap [m^3] is added to `volume`.
	int find(const ist::Pose& X_WT, const MirroredBody& body, const ist::Pose& X_WB, int slot, LinearContact* out, int capacity,
		double& volume) noexcept;
	/// Processor time of the queries alone so far [us], of the calling threads; counted from measure() on.
	double queryMicroseconds() const noexcept { return m_queryMicroseconds; }
	void measure() noexcept { m_measures = true; }
	/// Queries that were answered by a coarser level than the leaves, to keep the budget.
	std::uint64_t coarsened() const noexcept { return m_coarsened; }
	/// Queries that no level could answer within the budget: they were asked without one, since no force at all would be worse.
	std::uint64_t overBudget() const noexcept { return m_overBudget; }
	/// Queries without an answer (ist::QueryStatus), and so without a force.
	std::uint64_t refused() const noexcept { return m_refused; }

private:
	ist::OverlapResult ask(const ist::Pose& X_WT, const MirroredBody& body, const ist::Pose& X_WB) noexcept;

	const ist::InnerSphereTree& m_tool;
	ist::QueryWorkspace m_workspace;
	TripleBuffer<std::unique_ptr<ist::QueryBuffers>>
		m_rooms;                // a room that was taken comes back with the workspace's own, and is freed by its maker
	std::size_t m_roomFor = 0;  // slots
	std::int64_t m_maxPairs;
	btISTContact m_contact;  // the law reads from it; its trees are not owned
	std::uint64_t m_coarsened = 0, m_overBudget = 0, m_refused = 0;
	bool m_measures = false;
	double m_queryMicroseconds = 0;
};

/// `patch` between A and B at their poses.
LinearContact linearContact(const btContactPatch& patch, const ist::Pose& X_WA, const ist::Pose& X_WB) noexcept;
btContactPatch contactPatch(const LinearContact& contact) noexcept;
}  // namespace devicebridge
