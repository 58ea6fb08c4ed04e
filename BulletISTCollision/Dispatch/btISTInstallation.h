// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Dispatch/btISTContext.h"
#include "BulletISTCollision/Registry/btISTRegistry.h"

#include <memory>
#include <string>
#include <utility>

class btCollisionDispatcher;
class btOverlappingPairCache;
class btPersistentManifold;

/// The entries of this library in the tables of one dispatcher. The last registration of the dispatcher that is destroyed removes them.
class btISTInstallation : public btISTRegistryListener
{
public:
	/// If `reason` is not empty, the tables stay as they are and the context has no effect.
	btISTInstallation(btCollisionDispatcher* d, std::shared_ptr<btISTContext> c, std::string reason)
		: dispatcher(reason.empty() ? d : nullptr),
		  refusal(std::move(reason)),
		  context(std::move(c))
	{
		install();
	}
	~btISTInstallation() override { uninstall(); }

	/// The installation whose functions stand in the tables of a dispatcher; null if there is none. Others may have overwritten some
	/// entries.
	static std::shared_ptr<btISTInstallation> in(btCollisionDispatcher& dispatcher);

	void install();
	/// True while every entry of both tables is ours.
	bool isComplete() const;
	void uninstall();
	void treeChanged(const btCollisionShape* shape) override;

	/// Cleans the pairs whose bodies have `shape`, and the pairs of compounds of which a child has it and is in contact. Pairs in another
	/// cache, such as a ghost object's, notice the change by themselves.
	void cleanPairsOf(const btCollisionShape* shape);
	void cleanPair(const btPersistentManifold& manifold);
	/// Cleans the pairs in which one body has `shape` or a compound that contains it; all pairs when `shape` is null.
	void clean(btOverlappingPairCache* cache, const btCollisionShape* shape);

	btCollisionDispatcher* dispatcher;  ///< null: the dispatcher is gone, or it was refused
	std::string refusal;
	btOverlappingPairCache* pairCache = nullptr;
	std::shared_ptr<btISTContext> context;
};
