// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeCache.h"

#include <atomic>
#include <memory>
#include <string>

namespace ist
{
/// A tree that was asked for. Read the rest only once `isDone()`; from then on it does not change.
class TreeOrder
{
public:
	bool isDone() const { return m_done.load(std::memory_order_acquire); }
	/// Null when it failed.
	const std::shared_ptr<const InnerSphereTree>& tree() const { return m_result.tree; }
	const std::string& error() const { return m_error; }  ///< empty when it did not fail
	bool fromCache() const { return m_result.fromCache; }
	const std::string& note() const { return m_result.note; }  ///< see CachedTree

private:
	friend class TreeWorker;
	std::atomic<bool> m_done{false};
	CachedTree m_result;
	std::string m_error;
	std::shared_ptr<const TreeOrder> m_plain;  // of a tree with levels
};

/// One thread that builds and loads trees, one after the other in the order they were asked for. Whoever asks never waits for it. The same
/// mesh with the same options, or the same file, is one order, and one tree, while anybody holds it; one that failed is tried
/// again for whoever asks again. An order that nobody holds any more when its turn comes is dropped.
class TreeWorker
{
public:
	/// See cachedTree.
	explicit TreeWorker(std::string cacheFolder = "", double mostDoubt = 0.05);
	/// Breaks off what is being built; open orders end with an error.
	~TreeWorker();
	TreeWorker(const TreeWorker&) = delete;
	TreeWorker& operator=(const TreeWorker&) = delete;

	/// O(triangles), for the hash. `options.progress` is called on the worker's thread.
	std::shared_ptr<const TreeOrder> build(Mesh mesh, const BuildOptions& options);
	/// An .ist file.
	std::shared_ptr<const TreeOrder> load(const std::string& path);
	/// The tree of an order that is done, with levels (addLevels); a copy that shares its leaves.
	std::shared_ptr<const TreeOrder> addLevels(std::shared_ptr<const TreeOrder> plain);
	/// Blocks until every order is done: for loading screens and tests.
	void finish();

private:
	struct Shared;
	std::unique_ptr<Shared> m_shared;
};
}  // namespace ist
