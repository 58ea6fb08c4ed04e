// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTContactTest.h"

#include "BulletISTCollision/Registry/btISTClassOf.h"

#include "BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h"

#include <new>

namespace
{
struct Probe final : btCollisionAlgorithm
{
	explicit Probe(const void*& found) : table(found) {}
	void processCollision(
		const btCollisionObjectWrapper*, const btCollisionObjectWrapper*, const btDispatcherInfo&, btManifoldResult* result) override
	{
		table = btISTVirtualTable(result);
	}
	btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&, btManifoldResult*) override
	{
		return 1;
	}
	void getAllContactManifolds(btManifoldArray&) override {}

	const void*& table;
};

struct ProbeDispatcher final : btCollisionDispatcher
{
	using btCollisionDispatcher::btCollisionDispatcher;
	btCollisionAlgorithm* findAlgorithm(
		const btCollisionObjectWrapper*, const btCollisionObjectWrapper*, btPersistentManifold*, ebtDispatcherQueryType) override
	{
		return new (m_memory) Probe(table);  // the test calls its destructor
	}
	void freeCollisionAlgorithm(void*) override {}

	const void* table = nullptr;

private:
	alignas(Probe) unsigned char m_memory[sizeof(Probe)];
};

struct NoContact final : btCollisionWorld::ContactResultCallback
{
	btScalar addSingleResult(
		btManifoldPoint&, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int) override
	{
		return 0;
	}
};

const void* tableInContactTest()
{
	btDefaultCollisionConstructionInfo smallest;
	smallest.m_defaultMaxPersistentManifoldPoolSize = smallest.m_defaultMaxCollisionAlgorithmPoolSize = 1;
	btDefaultCollisionConfiguration configuration(smallest);
	ProbeDispatcher dispatcher(&configuration);
	btCollisionWorld world(&dispatcher, nullptr, &configuration);
	btCollisionObject a, b;
	NoContact callback;
	world.contactPairTest(&a, &b, callback);
	return dispatcher.table;
}
}  // namespace

const void* btISTTableOfContactTests()
{
	static const void* const table = tableInContactTest();
	return table;
}
