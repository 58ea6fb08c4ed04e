// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTRegistry.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"

#include <algorithm>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

struct btISTAttachment::Table
{
	struct Entry
	{
		std::shared_ptr<const ist::InnerSphereTree> tree;
		btVector3 scaling;  // scaling of the shape for which the tree is valid
	};

	std::unordered_map<const btCollisionShape*, Entry> trees;
	std::vector<std::weak_ptr<btISTRegistryListener>> listeners;
	bool keepsLevels = false;
	uint64_t version = 0;
	/// A tree as it was attached, and its copy with levels.
	struct Levelled
	{
		std::weak_ptr<const ist::InnerSphereTree> plain, levelled;
	};
	std::vector<Levelled> copies;

	/// Returns `tree`, with levels if they are required. Trees that are shared stay shared.
	std::shared_ptr<const ist::InnerSphereTree> withLevels(std::shared_ptr<const ist::InnerSphereTree> tree)
	{
		if (!keepsLevels || ist::hasLevels(*tree)) return tree;
		copies.erase(
			std::remove_if(copies.begin(), copies.end(), [](const Levelled& c) { return c.plain.expired() || c.levelled.expired(); }),
			copies.end());
		for (const Levelled& copy : copies)
			if (copy.plain.lock() == tree) return copy.levelled.lock();
		const auto levelled = std::make_shared<ist::InnerSphereTree>(*tree);
		ist::addLevels(*levelled);
		copies.push_back({tree, levelled});
		return levelled;
	}

	void announce(const btCollisionShape* shape)
	{
		++version;
		listeners.erase(std::remove_if(listeners.begin(), listeners.end(), [](const auto& l) { return l.expired(); }), listeners.end());
		const auto current = listeners;
		for (const auto& weak : current)
			if (const auto listener = weak.lock()) listener->treeChanged(shape);
	}
};

namespace
{
// A scaling is set by the user or read from a file, never computed by Bullet. So this tolerance covers rounding only.
constexpr double kScalingTolerance = 1e-6;

/// The reason why `shape` cannot carry `tree`; empty if it can.
std::string refusal(const btCollisionShape* shape, const ist::InnerSphereTree* tree, bool scaled)
{
	if (!shape) return "cannot attach a tree to a null shape";
	if (!tree) return "cannot attach a null tree; build or load one first";
	if (shape->isSoftBody()) return "soft bodies change their shape and cannot carry a tree";
	if (shape->isInfinite()) return "an unbounded shape cannot carry a tree; planes meet trees without one";
	if (!scaled && !btISTRegistry::hasScaling(*shape, btVector3(1, 1, 1)))
		return "the shape has a local scaling other than 1; scale the mesh, build its tree and leave the scaling at 1";
	const std::string problem = tree->validate();
	return problem.empty() ? std::string() : "the tree is not valid: " + problem;
}
}  // namespace

btISTAttachment::btISTAttachment(std::shared_ptr<Table> table, const btCollisionShape* shape) : m_table(std::move(table)), m_shape(shape) {}

btISTAttachment::~btISTAttachment() { detach(); }

btISTAttachment::btISTAttachment(btISTAttachment&& other) noexcept
	: m_table(std::move(other.m_table)),
	  m_shape(std::exchange(other.m_shape, nullptr))
{}

btISTAttachment& btISTAttachment::operator=(btISTAttachment&& other) noexcept
{
	if (this == &other) return *this;
	detach();
	m_table = std::move(other.m_table);
	m_shape = std::exchange(other.m_shape, nullptr);
	return *this;
}

void btISTAttachment::detach()
{
	if (!m_shape) return;
	const btCollisionShape* shape = std::exchange(m_shape, nullptr);
	const auto table = std::move(m_table);
	table->trees.erase(shape);
	table->announce(shape);
}

btISTRegistry::btISTRegistry() : m_table(std::make_shared<btISTAttachment::Table>()) {}
btISTRegistry::~btISTRegistry() = default;

ist::Result<btISTAttachment> btISTRegistry::attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree)
{
	return add(shape, std::move(tree), false);
}

ist::Result<btISTAttachment> btISTRegistry::attachScaled(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree)
{
	return add(shape, std::move(tree), true);
}

ist::Result<btISTAttachment> btISTRegistry::add(
	const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree, bool scaled)
{
	const std::string reason = refusal(shape, tree.get(), scaled);
	if (!reason.empty()) return ist::Error{reason};
	if (m_table->trees.count(shape)) return ist::Error{"the shape has a tree already; detach it first"};
	m_table->trees.emplace(shape, btISTAttachment::Table::Entry{m_table->withLevels(std::move(tree)), shape->getLocalScaling()});
	m_table->announce(shape);
	return btISTAttachment(m_table, shape);
}

std::shared_ptr<const ist::InnerSphereTree> btISTRegistry::find(const btCollisionShape* shape) const
{
	const auto found = m_table->trees.find(shape);
	if (found == m_table->trees.end() || !hasScaling(*shape, found->second.scaling)) return nullptr;
	return found->second.tree;
}

bool btISTRegistry::hasScaling(const btCollisionShape& shape, const btVector3& scaling)
{
	const btVector3& s = shape.getLocalScaling();
	for (int axis = 0; axis < 3; ++axis)
		if (!(std::fabs(double(s[axis]) - double(scaling[axis])) <= kScalingTolerance * std::fabs(double(scaling[axis])))) return false;
	return true;
}

bool btISTRegistry::isAttached(const btCollisionShape* shape) const { return m_table->trees.count(shape) > 0; }
uint64_t btISTRegistry::version() const { return m_table->version; }
int btISTRegistry::size() const { return int(m_table->trees.size()); }

void btISTRegistry::keepLevels()
{
	if (std::exchange(m_table->keepsLevels, true)) return;
	std::vector<const btCollisionShape*> changed;
	for (auto& [shape, entry] : m_table->trees)
	{
		std::shared_ptr<const ist::InnerSphereTree> levelled = m_table->withLevels(entry.tree);
		if (levelled == entry.tree) continue;
		entry.tree = std::move(levelled);
		changed.push_back(shape);
	}
	for (const btCollisionShape* shape : changed) m_table->announce(shape);
}

bool btISTRegistry::keepsLevels() const { return m_table->keepsLevels; }

void btISTRegistry::addListener(std::weak_ptr<btISTRegistryListener> listener) { m_table->listeners.push_back(std::move(listener)); }
