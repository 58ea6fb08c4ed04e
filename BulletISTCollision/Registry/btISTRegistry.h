// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include <cstdint>
#include <memory>

class btCollisionShape;
class btVector3;

/// Told after a shape has gained or lost its tree, so that algorithms that were chosen before can be thrown away.
class btISTRegistryListener
{
public:
	virtual ~btISTRegistryListener() = default;
	virtual void treeChanged(const btCollisionShape* shape) = 0;
};

/// Keeps a shape's tree attached for as long as it lives. Destroy it before the shape: the address of a deleted shape may be
/// given to a new one. May outlive the registry and the world. Move-only.
class btISTAttachment
{
public:
	btISTAttachment() = default;
	~btISTAttachment();
	btISTAttachment(btISTAttachment&& other) noexcept;
	btISTAttachment& operator=(btISTAttachment&& other) noexcept;

	bool isAttached() const { return m_shape != nullptr; }
	const btCollisionShape* shape() const { return m_shape; }
	/// What the destructor does.
	void detach();

private:
	friend class btISTRegistry;
	struct Table;
	btISTAttachment(std::shared_ptr<Table> table, const btCollisionShape* shape);

	std::shared_ptr<Table> m_table;
	const btCollisionShape* m_shape = nullptr;
};

/// Which shapes speak through which trees. The key is the shape's address, so that the children of compounds work, and shared
/// shapes share a tree. The frame of the shape is the mesh frame of the tree. One owner thread: that of the world.
class btISTRegistry
{
public:
	btISTRegistry();
	~btISTRegistry();
	btISTRegistry(const btISTRegistry&) = delete;
	btISTRegistry& operator=(const btISTRegistry&) = delete;

	/// Refused, with the reason: no shape, no tree, a tree that breaks an invariant (O(leaves)), a shape that has a tree already, an
	/// unbounded or soft shape, a local scaling other than 1. Not to be called while a step is in progress.
	[[nodiscard]] ist::Result<btISTAttachment> attach(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree);

	/// As `attach`, with a tree of the shape as it is now, local scaling included. It speaks for the shape while it has that scaling.
	[[nodiscard]] ist::Result<btISTAttachment> attachScaled(
		const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree);

	/// Null when nothing is attached, or when the shape was scaled since.
	std::shared_ptr<const ist::InnerSphereTree> find(const btCollisionShape* shape) const;
	bool isAttached(const btCollisionShape* shape) const;
	/// Grows whenever a shape gains or loses a tree.
	uint64_t version() const;
	/// Shapes that have a tree.
	int size() const;
	/// Whether its local scaling is `scaling`: a tree speaks for no other.
	static bool hasScaling(const btCollisionShape& shape, const btVector3& scaling);

	/// From now on every attached tree has levels (ist::addLevels), those that are attached already among them: a tree without gets a copy
	/// that shares its leaves. Takes some milliseconds per 1,000 leaves and tree, in `attach`; nothing for trees that bring theirs. Between
	/// steps only.
	void keepLevels();
	bool keepsLevels() const;

	/// Called for as long as it lives.
	void addListener(std::weak_ptr<btISTRegistryListener> listener);

private:
	ist::Result<btISTAttachment> add(const btCollisionShape* shape, std::shared_ptr<const ist::InnerSphereTree> tree, bool scaled);

	std::shared_ptr<btISTAttachment::Table> m_table;
};
