// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Dispatch/btISTContactTest.h"
#include "BulletISTCollision/Dispatch/btISTDeflectedPairs.h"
#include "BulletISTCollision/Dispatch/btISTQueryThreads.h"
#include "BulletISTCollision/PairQuery/btISTClusters.h"
#include "BulletISTCollision/PairQuery/btISTPairQuery.h"
#include "BulletISTCollision/PairQuery/btISTVerletLists.h"
#include "BulletISTCollision/Registry/btISTPairFilter.h"
#include "BulletISTCollision/Registry/btISTRegistry.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "BulletCollision/BroadphaseCollision/btBroadphaseProxy.h"
#include "BulletCollision/CollisionDispatch/btCollisionCreateFunc.h"

#include <memory>

class btISTContext;
class btISTInstallation;

/// The create function for all entries of one table. It finds out from the shapes for which entry it was called.
struct btISTCreateFunc : btCollisionAlgorithmCreateFunc
{
	btISTContext* context = nullptr;
	bool closest = false;
	btCollisionAlgorithmCreateFunc* previous[MAX_BROADPHASE_COLLISION_TYPES][MAX_BROADPHASE_COLLISION_TYPES] = {};
	/// The functions that stood in the table first. A library that registered after us may delegate to us, and after `reinstall` we
	/// delegate to it. These first functions end that cycle.
	btCollisionAlgorithmCreateFunc* first[MAX_BROADPHASE_COLLISION_TYPES][MAX_BROADPHASE_COLLISION_TYPES] = {};

	btCollisionAlgorithm* CreateCollisionAlgorithm(
		btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* wrap0, const btCollisionObjectWrapper* wrap1) override;
	/// The algorithm that the function before us makes for these types.
	btCollisionAlgorithm* delegate(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* wrap0,
		const btCollisionObjectWrapper* wrap1, int type0, int type1);

private:
	struct Delegated
	{
		const btCollisionObjectWrapper* wrap0 = nullptr;
		const btCollisionObjectWrapper* wrap1 = nullptr;
		int type0 = 0, type1 = 0;
	};
	Delegated m_delegated;  // the call that is being delegated now
};

/// State that all algorithms of one registration share. It lives as long as one of them or a registration lives.
class btISTContext : public std::enable_shared_from_this<btISTContext>
{
public:
	btISTContext()
	{
		contacts.context = closest.context = this;
		closest.closest = true;
		store.setMotionProbe(&deflectedPairs);
	}
	btISTCreateFunc& function(bool ofClosest) { return ofClosest ? closest : contacts; }

	btISTCreateFunc contacts, closest;
	bool active = true;
	const void* const tableOfContactTests = btISTTableOfContactTests();
	btISTContactStore store;
	std::shared_ptr<btISTRegistry> registry;
	btISTPairFilter pairFilter;
	std::shared_ptr<const btISTPairRule> rule = std::make_shared<btISTDefaultPairRule>();
	std::weak_ptr<const void> ruleClaim;  ///< claim of the handle that set the rule; when expired, any handle may set one
	ist::QueryWorkspace workspace;
	btISTQueryRules rules;
	btISTClusters clusters;
	btISTDeflectedPairs deflectedPairs{*this};
	btISTContact later;                          ///< for queries along the motion of a contact
	std::unique_ptr<btISTVerletLists> memories;  ///< null: every query starts a new traversal
	std::unique_ptr<btISTQueryThreads> threads;  ///< null: only the owner's thread queries
	std::weak_ptr<btISTInstallation> installation;
};
