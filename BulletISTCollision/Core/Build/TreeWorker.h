// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeCache.h"

#include <atomic>
#include <memory>
#include <string>

namespace ist
{
/// A tree that was ordered. Read the other members only after `isDone()` returned true; from then on they do not change.
class TreeOrder
{
public:
	bool isDone() const { return m_done.load(std::memory_order_acquire); }
	/// The tree; null if the order failed.
	const std::shared_ptr<const InnerSphereTree>& tree() const { return m_result.tree; }
	const std::string& error() const { return m_error; }  ///< reason of a failure, else empty
	bool fromCache() const { return m_result.fromCache; }
	const std::string& note() const { return m_result.note; }  ///< see CachedTree

private:
	friend class TreeWorker;
	std::atomic<bool> m_done{false};
	CachedTree m_result;
	std::string m_error;
	std::shared_ptr<const TreeOrder> m_plain;  // order of the plain tree, if this one is for a tree with levels
};

/// One thread that builds and loads trees in the order of the requests. A request never waits for it. While a reference
/// to an order exists, requests for the same mesh and options, or for the same file, share it and its tree. An order that failed is
/// tried again at the next request. An order without references is dropped when its turn comes.
class TreeWorker
{
public:
	/// See cachedTree.
	explicit TreeWorker(std::string cacheFolder = "", double mostDoubt = 0.05);
	/// Cancels the current build. Open orders end with an error.
	~TreeWorker();
	TreeWorker(const TreeWorker&) = delete;
	TreeWorker& operator=(const TreeWorker&) = delete;

	/// Orders a tree of a mesh. Cost: O(triangles), for the hash. `options.progress` is called on the worker's thread.
	std::shared_ptr<const TreeOrder> build(Mesh mesh, const BuildOptions& options);
	/// Orders a tree from an .ist file.
	std::shared_ptr<const TreeOrder> load(const std::string& path);
	/// Orders the tree of a finished order with levels (addLevels). It is a copy that shares the leaves.
	std::shared_ptr<const TreeOrder> addLevels(std::shared_ptr<const TreeOrder> plain);
	/// Blocks until every order is done. For loading screens and tests.
	void finish();

private:
	struct Shared;
	std::unique_ptr<Shared> m_shared;
};
}  // namespace ist
