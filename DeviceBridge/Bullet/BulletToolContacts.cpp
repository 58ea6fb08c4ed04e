// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletToolContacts.h"
#include "BulletISTCollision/Core/Base/ThreadTime.h"

#include <algorithm>
#include <limits>

namespace devicebridge
{
namespace
{
std::shared_ptr<const ist::InnerSphereTree> notOwned(const ist::InnerSphereTree* tree)
{
	return {std::shared_ptr<const ist::InnerSphereTree>(), tree};
}
}  // namespace

BulletToolContacts::BulletToolContacts(const std::vector<ToolPart>& tool, std::int64_t maxPairs) : m_tool(tool), m_maxPairs(maxPairs)
{
	for (const ToolPart& part : tool)
	{
		if (!part.tree) continue;
		m_workspace.reserve(*part.tree, *part.tree);
		m_buffersFor = std::max(m_buffersFor, mostSlots(*part.tree));
	}
	m_workspace.makeResident();
}

void BulletToolContacts::reserve(const ist::InnerSphereTree& tree)
{
	const std::size_t slots = mostSlots(tree);
	if (slots <= m_buffersFor) return;
	// It serves queries of this tree with any part of the tool, because no part has more slots.
	m_buffers.writable() = std::make_unique<ist::QueryBuffers>(tree, tree);
	m_buffers.publish();
	m_buffersFor = slots;
}

/// The tool is A if its part has a tree; otherwise the body is.
BulletToolContacts::Sides BulletToolContacts::sidesOf(
	const ToolPart& part, const ist::Pose& X_WT, const MirroredPair& pair, const ist::Pose& X_WB) noexcept
{
	const ist::Pose X_WP = X_WT * part.X_TP, X_WQ = X_WB * pair.X_BP;
	if (part.tree) return {part.tree.get(), pair.tree, &pair.field, X_WP, X_WQ, pair.toolWeight};
	return {pair.tree, nullptr, &part.field, X_WQ, X_WP, 1 - pair.toolWeight};
}

ist::OverlapResult BulletToolContacts::ask(const Sides& sides, double dissipation) noexcept
{
	ist::QueryOptions options;
	if (dissipation > 0) options.damping = {sides.weightA, 1 - sides.weightA};
	const ist::Pose X_AB = inverse(sides.X_WA) * sides.X_WB;
	if (!sides.treeB)  // a closed form has no levels
	{
		const ist::AnalyticField* field = ist::fieldIn(*sides.fieldB);
		if (field) return queryField(*sides.treeA, *field, X_AB, m_workspace, options);
		ist::OverlapResult none;
		none.status = ist::QueryStatus::InvalidPose;
		return none;
	}
	options.maxPairs = m_maxPairs;
	const ist::OverlapResult result = queryOverlap(*sides.treeA, *sides.treeB, X_AB, m_workspace, options);
	if (result.status != ist::QueryStatus::BudgetTooSmall) return result;
	++m_overBudget;
	options.maxPairs = -1;
	return queryOverlap(*sides.treeA, *sides.treeB, X_AB, m_workspace, options);
}

int BulletToolContacts::find(const ist::Pose& X_WT, const MirroredPair& pair, const MirroredBody& body, const ist::Pose& X_WB,
	LinearContact* out, int capacity, double& volume) noexcept
{
	if (m_buffers.fetch()) m_workspace.take(*m_buffers.readable());
	const ToolPart& part = m_tool[std::size_t(pair.toolPart)];
	const Sides sides = sidesOf(part, X_WT, pair, X_WB);
	if (!sides.treeA) return 0;
	const double begin = m_measures ? ist::threadMicroseconds() : 0;
	const ist::OverlapResult result = ask(sides, pair.dissipation);
	if (m_measures) m_queryMicroseconds += ist::threadMicroseconds() - begin;
	m_refused += result.status != ist::QueryStatus::Ok;
	if (result.status != ist::QueryStatus::Ok || !(result.total.volume > 0)) return 0;
	m_coarsened += result.coarsened;
	m_contact.treeA = notOwned(sides.treeA);
	m_contact.treeB = notOwned(sides.treeB);
	m_contact.X_WA = sides.X_WA;
	m_contact.constants.k = pair.k;
	m_contact.constants.weightA = sides.weightA;
	m_contact.constants.weightB = 1 - sides.weightA;
	m_contact.constants.dissipation = pair.dissipation;
	m_contact.total = result.total;
	m_contact.patchCount = std::min(result.patchCount, btISTContact::kMaxPatches);
	std::copy(result.patches, result.patches + m_contact.patchCount, m_contact.patches);
	volume += result.total.volume;

	int count = 0;
	btContactPatch patch;
	for (int i = 0; i < m_contact.patchCount; ++i)
	{
		if (!evaluateContactPatch(m_contact, i, patch)) continue;
		if (count == capacity)
		{
			++m_dropped;
			continue;
		}
		LinearContact& c = out[count++] = linearContact(patch, X_WT, X_WB);
		if (!part.tree)  // the law gave the wrench on the body
		{
			c.normal = -c.normal;
			c.wrench = -1.0 * c.wrench;
		}
		c.a = LinearContact::kTool;
		c.b = pair.slot;
		c.epoch = body.epoch;
		c.friction = body.friction;
		c.restDepth = pair.restDepth;
		c.volume = m_contact.patches[i].volume;
		c.pairs = static_cast<int>(std::min<std::int64_t>(m_contact.patches[i].pairs, std::numeric_limits<int>::max()));
	}
	return count;
}

LinearContact linearContact(const btContactPatch& patch, const ist::Pose& X_WA, const ist::Pose& X_WB) noexcept
{
	LinearContact c;
	c.point = patch.point;
	c.normal = patch.normal;
	c.wrench = patch.wrench;
	c.stiffness = patch.stiffness;
	c.damping = patch.damping;
	c.frictionRadius = patch.frictionRadius;
	c.frictionFactor = patch.frictionFactor;
	c.X_WA = X_WA;
	c.X_WB = X_WB;
	return c;
}

btContactPatch contactPatch(const LinearContact& c) noexcept
{
	return {c.point, c.normal, c.wrench, c.stiffness, c.damping, c.frictionRadius, c.frictionFactor};
}
}  // namespace devicebridge
