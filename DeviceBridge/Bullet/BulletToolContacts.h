// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "BulletHapticForce/Law/btContactLaw.h"
#include "DeviceBridge/Loop/WorldMirror.h"
#include "DeviceBridge/Timing/TripleBuffer.h"

namespace devicebridge
{
/// A part of the tool's shape, which is its only one unless the shape is a compound. P is the part's frame: the mesh frame of its tree, or
/// the frame of its closed form. T is the tool's centre-of-mass frame.
struct ToolPart
{
	std::shared_ptr<const ist::InnerSphereTree> tree;  ///< null: `field`
	ist::AnyField field;                               ///< closed form of a part without a tree
	ist::Pose X_TP;
	ist::Vec3 center;  ///< centre of a ball around the part, in T [m]
	double radius = 0;
};

/// A part of the tool's shape that feels nothing.
struct UnfeltToolPart
{
	int index = 0;             ///< number of the part, in the order of the compound's children
	std::string shape;         ///< Bullet's name of the shape
	bool wasScaled = false;    ///< whether the shape has a tree, but was scaled after the tree was attached
	bool isHalfSpace = false;  ///< whether it is a plane, which cannot be a part of a tool
};

/// Contacts of the tool with mirrored bodies, found as btISTCollisionAlgorithm finds them: by queries of two trees, or of a tree and a
/// closed form. One thread queries. It allocates nothing for closed forms, for trees of the tool's size, and for trees that another thread
/// passed to reserve(). In the first query of a larger tree it allocates.
class BulletToolContacts
{
public:
	/// The tool's parts must outlive this object. `maxPairs` is the budget of a query, see ist::QueryOptions; negative: no limit.
	explicit BulletToolContacts(const std::vector<ToolPart>& tool, std::int64_t maxPairs = -1);

	/// Reserves memory for queries of `tree`. One other thread may call it, before the querying thread receives a body with this tree. It
	/// allocates about 120 bytes per leaf if no larger tree came before.
	void reserve(const ist::InnerSphereTree& tree);

	// For the thread that queries:
	/// Finds the patches of a pair between the tool at X_WT and `body` at X_WB. Returns their number, at most `capacity`. The tool is A.
	/// The overlap volume [m^3] is added to `volume`.
	int find(const ist::Pose& X_WT, const MirroredPair& pair, const MirroredBody& body, const ist::Pose& X_WB, LinearContact* out,
		int capacity, double& volume) noexcept;
	/// Processor time of the queries alone [us], on the calling threads, since measure().
	double queryMicroseconds() const noexcept { return m_queryMicroseconds; }
	void measure() noexcept { m_measures = true; }
	/// Number of queries that used a coarser level than the leaves to stay within the budget.
	std::uint64_t coarsened() const noexcept { return m_coarsened; }
	/// Number of queries that exceed the budget at every level. They ran without a budget, because no force at all would be worse.
	std::uint64_t overBudget() const noexcept { return m_overBudget; }
	/// Number of queries without an answer (ist::QueryStatus), and so without a force.
	std::uint64_t refused() const noexcept { return m_refused; }
	/// Number of patches that found no place in the array of the caller, and so without a force.
	std::uint64_t dropped() const noexcept { return m_dropped; }

private:
	/// A pair as the law sees it: A has a tree.
	struct Sides
	{
		const ist::InnerSphereTree* treeA;
		const ist::InnerSphereTree* treeB;  ///< null: `fieldB`
		const ist::AnyField* fieldB;
		ist::Pose X_WA, X_WB;
		double weightA;
	};
	static Sides sidesOf(const ToolPart& part, const ist::Pose& X_WT, const MirroredPair& pair, const ist::Pose& X_WB) noexcept;
	ist::OverlapResult ask(const Sides& sides, double dissipation) noexcept;

	const std::vector<ToolPart>& m_tool;
	ist::QueryWorkspace m_workspace;
	TripleBuffer<std::unique_ptr<ist::QueryBuffers>>
		m_buffers;                 // new buffers; fetched ones are exchanged for the workspace's own, which the thread of reserve() frees
	std::size_t m_buffersFor = 0;  // number of slots in the largest buffers so far
	std::int64_t m_maxPairs;
	btISTContact m_contact;  // pair that the contact law reads; it does not own its trees
	std::uint64_t m_coarsened = 0, m_overBudget = 0, m_refused = 0, m_dropped = 0;
	bool m_measures = false;
	double m_queryMicroseconds = 0;
};

/// The linear model of `patch` between A and B at their poses.
LinearContact linearContact(const btContactPatch& patch, const ist::Pose& X_WA, const ist::Pose& X_WB) noexcept;
btContactPatch contactPatch(const LinearContact& contact) noexcept;
}  // namespace devicebridge
