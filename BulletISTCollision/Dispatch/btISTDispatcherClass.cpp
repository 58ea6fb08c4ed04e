// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTDispatcherClass.h"

#include "BulletISTCollision/Registry/btISTClassOf.h"

#include "BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h"
#include "BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h"
#include "LinearMath/btThreads.h"

namespace
{
template <class Dispatcher> const void* tableOf()
{
	btDefaultCollisionConstructionInfo smallest;
	smallest.m_defaultMaxPersistentManifoldPoolSize = smallest.m_defaultMaxCollisionAlgorithmPoolSize = 1;
	btDefaultCollisionConfiguration configuration(smallest);
	const Dispatcher example(&configuration);
	return btISTVirtualTable(&example);
}

const void* tableOfThreadedOnes()
{
	// The constructor asks the scheduler, so without one the program has no such dispatcher either.
	return btGetTaskScheduler() ? tableOf<btCollisionDispatcherMt>() : nullptr;
}
}  // namespace

btCollisionDispatcher* btISTAsCollisionDispatcher(btDispatcher* dispatcher)
{
	if (auto* threaded = btISTCast<btCollisionDispatcherMt>(dispatcher, tableOfThreadedOnes)) return threaded;
	return btISTCast<btCollisionDispatcher>(dispatcher, tableOf<btCollisionDispatcher>);
}

bool btISTIsThreaded(const btCollisionDispatcher& dispatcher)
{
	return btISTCast<const btCollisionDispatcherMt>(&dispatcher, tableOfThreadedOnes) != nullptr;
}
