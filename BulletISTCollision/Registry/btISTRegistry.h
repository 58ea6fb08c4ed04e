// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include <cstdint>
#include <memory>

class btCollisionShape;
class btVector3;

/// Listener that is called after a shape has gained or lost its tree, so that algorithms that were chosen before can be destroyed.
class btISTRegistryListener
{
public:
	virtual ~btISTRegistryListener() = default;
	virtual void treeChanged(const btCollisionShape* shape) = 0;
};

/// Keeps a tree attached to a shape during its lifetime. Destroy it before the shape, because the address of a deleted shape may be given
/// to a new one. It may outlive the registry and the world. Move-only.
class btISTAttachment
{
public:
	btISTAttachment() = default;
	~btISTAttachment();
	btISTAttachment(btISTAttachment&& other) noexcept;
	btISTAttachment& operator=(btISTAttachment&& other) noexcept;

	bool isAttached() const { return m_shape != nullptr; }
	const btCollisionShape* shape() const { return m_shape; }
	/// Does what the destructor does.
	void detach();

private:
	friend class btISTRegistry;
	struct Table;
	btISTAttachment(std::shared_ptr<Table> table, const btCollisionShape* shape);

	std::shared_ptr<Table> m_table;
	const btCollisionShape* m_shape = nullptr;
};

/// The table of shapes and their trees. The key is the shape's address, so that children of compounds work and shared shapes share a
/// tree. The frame of the shape is the mesh frame of the tree. One owner thread: the world's.
class btISTRegistry
{
public:
	btISTRegistry();
	~btISTRegistry();
	btISTRegistry(const btISTRegistry&) = delete;
	btISTRegistry& operator=(const btISTRegistry&) = delete;

	/// Attaches `tree` to `shape`. Refused, with the reason: a null shape or tree, a tree that breaks an invariant (O(leaves)), a shape
	/// that has a tree already, an unbounded or soft shape, a local scaling other than 1. Do not call it during a step.
	[[nodiscard]] ist::Result<btISTAttachment> attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree);

	/// Like `attach`, for a tree of the shape as it is now, local scaling included. The tree is valid while the shape has that scaling.
	[[nodiscard]] ist::Result<btISTAttachment> attachScaled(
		const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree);

	/// The tree of a shape; null if nothing is attached or if the shape was scaled since.
	std::shared_ptr<const ist::InnerSphereTree> find(const btCollisionShape* shape) const;
	bool isAttached(const btCollisionShape* shape) const;
	/// Number that grows whenever a shape gains or loses a tree.
	uint64_t version() const;
	/// Number of shapes that have a tree.
	int size() const;
	/// Whether the local scaling of `shape` is `scaling`. A tree is valid for one scaling only.
	static bool hasScaling(const btCollisionShape& shape, const btVector3& scaling);

	/// From now on every attached tree has levels (ist::addLevels), the present ones included. A tree without levels gets a copy that
	/// shares its leaves. This takes some milliseconds per 1,000 leaves and tree, in `attach`; nothing for trees that have levels. Call
	/// it between steps only.
	void keepLevels();
	bool keepsLevels() const;

	/// Adds a listener, which is called during its lifetime.
	void addListener(std::weak_ptr<btISTRegistryListener> listener);

private:
	ist::Result<btISTAttachment> add(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree, bool scaled);

	std::shared_ptr<btISTAttachment::Table> m_table;
};
