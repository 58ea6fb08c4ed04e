// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Dispatch/btISTRegistration.h"
#include "BulletISTCollision/Registry/btISTRegistry.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h"

#include <memory>

class btCollisionDispatcher;
class btISTContext;
class btISTPairQuery;

/// Contact of two trees, or of a tree and one of Bullet's plane, box, sphere, capsule, cylinder and cone. The manifold stays empty and
/// Bullet's own algorithm works in place of this one in these cases:
/// - the pair filter (btISTPairFilter) does not accept the pair;
/// - a shape with a tree has another local scaling than when the pair was made;
/// - a body got a shape without a tree, or its shape lost the tree;
/// - the axes of a body are more than 5 % away from unit length and right angles.
/// Objects live in the dispatcher's pool, which does not check sizes.
class btISTCollisionAlgorithm : public btCollisionAlgorithm
{
public:
	enum Mode
	{
		Respond,  ///< fills the contact store and owns its manifold for as long as the pair lives
		Query     ///< lives for one contact test; does not touch the store
	};

	/// `a` and `b` are in the order of the manifold; a body without a tree comes second. Their shapes must keep their present scaling.
	btISTCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info, std::shared_ptr<btISTContext> context, Mode mode,
		std::shared_ptr<const ist::InnerSphereTree> treeA, std::shared_ptr<const ist::InnerSphereTree> treeB,
		const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);
	~btISTCollisionAlgorithm() override;

	/// Registers for every pair of proxy types except soft bodies, in the tables of contacts and of closest points. Pairs that are not
	/// volumetric are delegated to the functions that were registered before. A second call on one dispatcher returns a second handle. A
	/// second call with another `registry` is refused (btISTRegistration::refusal), and the first registration stays as it is. Bullet's
	/// pools and tables have one owner thread, and so has this. Several worlds of one thread may share `registry`. A
	/// btCollisionDispatcherMt is refused, too, because it calls algorithms from several threads. To use several threads, give the world
	/// a btCollisionDispatcher and call `setQueryThreads`. A class without RTTI that derives from it is not recognised: never pass one.
	static btISTRegistration registerAlgorithm(
		btCollisionDispatcher* dispatcher, btOverlappingPairCache* pairCache = nullptr, std::shared_ptr<btISTRegistry> registry = nullptr);

	void processCollision(const btCollisionObjectWrapper* body0Wrap, const btCollisionObjectWrapper* body1Wrap,
		const btDispatcherInfo& dispatchInfo, btManifoldResult* resultOut) override;
	btScalar calculateTimeOfImpact(
		btCollisionObject* body0, btCollisionObject* body1, const btDispatcherInfo& dispatchInfo, btManifoldResult* resultOut) override;
	void getAllContactManifolds(btManifoldArray& manifoldArray) override;

private:
	/// Identity of a shape that was seen. The address alone is not enough: a shape without a tree may be deleted and its address reused.
	struct KnownShape
	{
		const btCollisionShape* shape;
		float scaling[3];
		int type;

		void keep(const btCollisionShape* known);
		bool is(const btCollisionShape* other) const;
		bool isKindOf(const btCollisionShape* other) const;  // the same, ignoring the scaling
	};

	void evaluate(const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB, double step, btISTContact& contact) const;
	void update(const btISTPairQuery& query, btISTContact& contact) const;
	void predictTouch(const btISTPairQuery& query, double step, btISTContact& contact) const;
	bool report(const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB, btManifoldResult& out) const;
	void see(const btCollisionShape* shapeA, const btCollisionShape* shapeB);
	void keepShapes(const btCollisionShape* shapeA, const btCollisionShape* shapeB);
	void forget();
	void createStock(const btCollisionObjectWrapper* body0Wrap, const btCollisionObjectWrapper* body1Wrap);
	void destroyStock();

	std::shared_ptr<btISTContext> m_context;
	std::shared_ptr<const ist::InnerSphereTree> m_treeA, m_treeB;
	btPersistentManifold* m_manifold;
	btISTContact* m_contact;                  // null in Query mode
	btCollisionAlgorithm* m_stock = nullptr;  // Bullet's algorithm, while it works in place of this one
	KnownShape m_A, m_B;
	uint32_t m_version;  // version of the registry at the last check
};
static_assert(sizeof(btISTCollisionAlgorithm) <= 144, "a pool element has 192 bytes, of which some are left to Bullet's future");
