// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTInstallation.h"

#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"
#include "BulletISTCollision/Registry/btISTClassOf.h"
#include "BulletISTCollision/Registry/btISTShapeField.h"
#include "BulletISTCollision/Registry/btISTShapeParts.h"

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"

#include <new>
#include <string>
#include <utility>
#include <vector>

namespace
{
constexpr int kTypes = MAX_BROADPHASE_COLLISION_TYPES;

/// Bullet makes an algorithm for each child of a GImpact compound and destroys it within the same call, before a solver sees the contact.
bool isInGImpactCompound(const btCollisionObjectWrapper* wrap)
{
	for (; wrap; wrap = wrap->m_parent)
	{
		const btCollisionShape* shape = wrap->getCollisionShape();
		if (shape->getShapeType() == GIMPACT_SHAPE_PROXYTYPE &&
			static_cast<const btGImpactShapeInterface*>(shape)->getGImpactShapeType() == CONST_GIMPACT_COMPOUND_SHAPE)
			return true;
	}
	return false;
}

/// Access to the tables, which are protected and have no getter. A pointer to member that is named through a derived class works on any
/// dispatcher.
struct DispatchTables : btCollisionDispatcher
{
	static btCollisionAlgorithmCreateFunc*& entry(btCollisionDispatcher& d, bool closest, int i, int j)
	{
		const auto table = closest ? &DispatchTables::m_doubleDispatchClosestPoints : &DispatchTables::m_doubleDispatchContactPoints;
		return (d.*table)[i][j];
	}
};

template <class Visit> void forEachEntry(Visit visit)
{
	for (int i = 0; i < kTypes; ++i)
		for (int j = 0; j < kTypes; ++j)
		{
			if (i == SOFTBODY_SHAPE_PROXYTYPE || j == SOFTBODY_SHAPE_PROXYTYPE) continue;
			visit(false, i, j);
			visit(true, i, j);
		}
}
}  // namespace

btCollisionAlgorithm* btISTCreateFunc::CreateCollisionAlgorithm(
	btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* wrap0, const btCollisionObjectWrapper* wrap1)
{
	if (m_delegated.wrap0 == wrap0 && m_delegated.wrap1 == wrap1)
		return first[m_delegated.type0][m_delegated.type1]->CreateCollisionAlgorithm(info, wrap0, wrap1);
	const btCollisionShape* shape0 = wrap0->getCollisionShape();
	const btCollisionShape* shape1 = wrap1->getCollisionShape();
	int type0 = shape0->getShapeType(), type1 = shape1->getShapeType();
	if (context->active && context->registry->size() > 0)
	{
		const btISTRegistry& registry = *context->registry;
		const bool attached0 = registry.isAttached(shape0), attached1 = registry.isAttached(shape1);
		const auto hasForm = [](const btCollisionShape* shape) { return btISTShapeField(shape).field() != nullptr; };
		const bool ours = (attached0 && attached1) || (attached0 && hasForm(shape1)) || (attached1 && hasForm(shape0));
		if (ours && !isInGImpactCompound(wrap0) && !isInGImpactCompound(wrap1))
		{
			const bool swapped = !attached0;  // A must have the tree
			auto treeA = registry.find(swapped ? shape1 : shape0), treeB = registry.find(swapped ? shape0 : shape1);
			// A shape that was scaled since its tree was attached is Bullet's until it has its size again.
			if (attached0 && attached1 && !treeB) treeA.reset();
			const auto mode = closest ? btISTCollisionAlgorithm::Query : btISTCollisionAlgorithm::Respond;
			void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(int(sizeof(btISTCollisionAlgorithm)));
			return new (memory) btISTCollisionAlgorithm(info, context->shared_from_this(), mode, std::move(treeA), std::move(treeB),
				*(swapped ? wrap1 : wrap0), *(swapped ? wrap0 : wrap1));
		}
		// GImpact handles the children of a compound itself and does not call the dispatcher for them. Bullet's compound algorithm does,
		// if the other shape looks convex. So the GImpact shape is passed as a box.
		if (registry.find(shape0) && type0 == GIMPACT_SHAPE_PROXYTYPE && type1 == COMPOUND_SHAPE_PROXYTYPE) type0 = BOX_SHAPE_PROXYTYPE;
		if (registry.find(shape1) && type1 == GIMPACT_SHAPE_PROXYTYPE && type0 == COMPOUND_SHAPE_PROXYTYPE) type1 = BOX_SHAPE_PROXYTYPE;
	}
	return delegate(info, wrap0, wrap1, type0, type1);
}

btCollisionAlgorithm* btISTCreateFunc::delegate(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* wrap0,
	const btCollisionObjectWrapper* wrap1, int type0, int type1)
{
	const Delegated outer = std::exchange(m_delegated, {wrap0, wrap1, type0, type1});
	btCollisionAlgorithm* algorithm = previous[type0][type1]->CreateCollisionAlgorithm(info, wrap0, wrap1);
	m_delegated = outer;
	return algorithm;
}

void btISTInstallation::install()
{
	if (!dispatcher) return;
	forEachEntry([this](bool closest, int i, int j) {
		btCollisionAlgorithmCreateFunc*& entry = DispatchTables::entry(*dispatcher, closest, i, j);
		btISTCreateFunc& ours = context->function(closest);
		if (entry == &ours) return;
		ours.previous[i][j] = entry;
		if (!ours.first[i][j]) ours.first[i][j] = entry;
		entry = &ours;
	});
}

bool btISTInstallation::isComplete() const
{
	bool complete = dispatcher != nullptr;
	if (complete)
		forEachEntry([&](bool closest, int i, int j) {
			complete = complete && DispatchTables::entry(*dispatcher, closest, i, j) == &context->function(closest);
		});
	return complete;
}

void btISTInstallation::uninstall()
{
	if (!dispatcher) return;
	bool foreign = false;
	forEachEntry([&](bool closest, int i, int j) {
		btCollisionAlgorithmCreateFunc*& entry = DispatchTables::entry(*dispatcher, closest, i, j);
		btISTCreateFunc& ours = context->function(closest);
		if (entry == &ours) entry = ours.previous[i][j];
		else foreign = true;
	});
	context->active = false;
	// A library that registered after us may hold our functions as its predecessors and call them at any later time, without a notice
	// when it stops. So the functions go on delegating; this leaks one context for each such registration.
	if (foreign) new std::shared_ptr<btISTContext>(context);
	dispatcher = nullptr;
}

void btISTInstallation::treeChanged(const btCollisionShape* shape)
{
	if (!pairCache || !dispatcher) return;
	// A shape that loses its tree may be about to be deleted, and other shapes may be deleted already. So no shape is dereferenced here.
	if (context->registry->isAttached(shape)) clean(pairCache, shape);
	else cleanPairsOf(shape);
}

void btISTInstallation::cleanPairsOf(const btCollisionShape* shape)
{
	const auto hasIt = [shape](const btBroadphaseProxy* proxy) {
		return static_cast<const btCollisionObject*>(proxy->m_clientObject)->getCollisionShape() == shape;
	};
	btBroadphasePairArray& pairs = pairCache->getOverlappingPairArray();
	for (int i = 0; i < pairs.size(); ++i)
		if (hasIt(pairs[i].m_pProxy0) || hasIt(pairs[i].m_pProxy1)) pairCache->cleanOverlappingPair(pairs[i], dispatcher);
	const std::vector<btISTContact*>& contacts = context->store.contacts();
	for (size_t i = 0; i < contacts.size();)
	{
		const btISTContact& contact = *contacts[i];
		const size_t before = contacts.size();
		if (contact.shapeA == shape || contact.shapeB == shape) cleanPair(*contact.manifold);
		// Removal has reordered the contacts, so the search begins again.
		if (contacts.size() < before) i = 0;
		else ++i;
	}
}

void btISTInstallation::cleanPair(const btPersistentManifold& manifold)
{
	btBroadphaseProxy* const a = const_cast<btBroadphaseProxy*>(manifold.getBody0()->getBroadphaseHandle());
	btBroadphaseProxy* const b = const_cast<btBroadphaseProxy*>(manifold.getBody1()->getBroadphaseHandle());
	btBroadphasePair* pair = a && b ? pairCache->findPair(a, b) : nullptr;
	if (pair) pairCache->cleanOverlappingPair(*pair, dispatcher);
}

void btISTInstallation::clean(btOverlappingPairCache* cache, const btCollisionShape* shape)
{
	btBroadphasePairArray& pairs = cache->getOverlappingPairArray();
	for (int i = 0; i < pairs.size(); ++i)
	{
		const auto involves = [&](const btBroadphaseProxy* proxy) {
			return btISTAnyPart(static_cast<const btCollisionObject*>(proxy->m_clientObject)->getCollisionShape(),
				[shape](const btCollisionShape* part) { return part == shape; });
		};
		if (!shape || involves(pairs[i].m_pProxy0) || involves(pairs[i].m_pProxy1)) cache->cleanOverlappingPair(pairs[i], dispatcher);
	}
}

std::shared_ptr<btISTInstallation> btISTInstallation::in(btCollisionDispatcher& dispatcher)
{
	std::shared_ptr<btISTInstallation> found;
	const btCollisionAlgorithmCreateFunc* last = nullptr;
	const auto tableOfOurs = [] {
		const btISTCreateFunc example;
		return btISTVirtualTable(&example);
	};
	forEachEntry([&](bool closest, int i, int j) {
		const btCollisionAlgorithmCreateFunc* entry = DispatchTables::entry(dispatcher, closest, i, j);
		if (found || entry == last) return;
		last = entry;
		if (const auto* ours = btISTCast<const btISTCreateFunc>(entry, tableOfOurs)) found = ours->context->installation.lock();
	});
	return found;
}
