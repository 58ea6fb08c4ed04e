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

BulletToolContacts::BulletToolContacts(const ist::InnerSphereTree& tool, std::int64_t maxPairs) : m_tool(tool), m_maxPairs(maxPairs)
{
	m_contact.treeA = notOwned(&tool);
	m_workspace.reserve(tool, tool);
	m_workspace.makeResident();
	m_buffersFor = mostSlots(tool);
}

void BulletToolContacts::reserve(const ist::InnerSphereTree& tree)
{
	const std::size_t slots = mostSlots(tree);
	if (slots <= m_buffersFor) return;
	m_buffers.writable() = std::make_unique<ist::QueryBuffers>(m_tool, tree);
	m_buffers.publish();
	m_buffersFor = slots;
}

ist::OverlapResult BulletToolContacts::ask(const ist::Pose& X_WT, const MirroredBody& body, const ist::Pose& X_WB) noexcept
{
	ist::QueryOptions options;
	if (body.dissipation > 0) options.damping = {body.toolWeight, 1 - body.toolWeight};
	if (!body.tree)  // a half-space has no levels
	{
		const ist::Vec3 normal = transpose(X_WT.rotation) * body.planeNormal;
		return queryHalfSpace(m_tool, normal, body.planeOffset - dot(body.planeNormal, X_WT.translation), m_workspace, options);
	}
	const ist::Pose X_TB = inverse(X_WT) * X_WB;
	options.maxPairs = m_maxPairs;
	const ist::OverlapResult result = queryOverlap(m_tool, *body.tree, X_TB, m_workspace, options);
	if (result.status != ist::QueryStatus::BudgetTooSmall) return result;
	++m_overBudget;
	options.maxPairs = -1;
	return queryOverlap(m_tool, *body.tree, X_TB, m_workspace, options);
}

int BulletToolContacts::find(const ist::Pose& X_WT, const MirroredBody& body, const ist::Pose& X_WB, int slot, LinearContact* out,
	int capacity, double& volume) noexcept
{
	if (m_buffers.fetch()) m_workspace.take(*m_buffers.readable());
	const double begin = m_measures ? ist::threadMicroseconds() : 0;
	const ist::OverlapResult result = ask(X_WT, body, X_WB);
	if (m_measures) m_queryMicroseconds += ist::threadMicroseconds() - begin;
	m_refused += result.status != ist::QueryStatus::Ok;
	if (result.status != ist::QueryStatus::Ok || !(result.total.volume > 0)) return 0;
	m_coarsened += result.coarsened;
	m_contact.treeB = notOwned(body.tree);
	m_contact.halfSpace = !body.tree;
	m_contact.X_WA = X_WT;
	m_contact.constants = {body.k, body.toolWeight, 1 - body.toolWeight, 0, body.dissipation};
	m_contact.total = result.total;
	m_contact.patchCount = std::min(result.patchCount, btISTContact::kMaxPatches);
	std::copy(result.patches, result.patches + m_contact.patchCount, m_contact.patches);
	volume += result.total.volume;

	int count = 0;
	btContactPatch patch;
	for (int i = 0; i < m_contact.patchCount && count < capacity; ++i)
	{
		if (!evaluateContactPatch(m_contact, i, patch)) continue;
		LinearContact& c = out[count++] = linearContact(patch, X_WT, X_WB);
		c.a = LinearContact::kTool;
		c.b = slot;
		c.epoch = body.epoch;
		c.friction = body.friction;
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
	c.X_WA = X_WA;
	c.X_WB = X_WB;
	return c;
}

btContactPatch contactPatch(const LinearContact& c) noexcept
{
	return {c.point, c.normal, c.wrench, c.stiffness, c.damping, c.frictionRadius};
}
}  // namespace devicebridge
