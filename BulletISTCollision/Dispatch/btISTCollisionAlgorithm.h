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

/// Contact of two trees, or of a tree and one of Bullet's plane, box, sphere, capsule, cylinder and cone. Bullet's own algorithm works in
/// its place, and the manifold stays empty, while the pair is not watched (btISTPairFilter), a shape with a tree has another local scaling
/// than when the pair was made, a body got a shape without one or lost its tree, or axes of a body are more than 5 % from unit length and
/// right angles. Lives in the dispatcher's pool, which does not check sizes.
class btISTCollisionAlgorithm : public btCollisionAlgorithm
{
public:
	enum Mode
	{
		Respond,  ///< fills the contact store and owns its manifold for as long as the pair lives
		Query     ///< lives for one contact test; does not touch the store
	};

	/// `a` and `b` in the order of the manifold, in which a body without a tree comes second. Their shapes keep the scaling that they have.
	btISTCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info, std::shared_ptr<btISTContext> context, Mode mode,
		std::shared_ptr<const ist::InnerSphereTree> treeA, std::shared_ptr<const ist::InnerSphereTree> treeB,
		const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);
	~btISTCollisionAlgorithm() override;

	/// Registers for every pair of proxy types but soft bodies, in the tables of contacts and of closest points, and delegates to
	/// what was registered before for every pair that is not volumetric. A second call on one dispatcher returns a second handle; with
	/// another `registry` than the first call it is refused (btISTRegistration::refusal), and the first registration stays as it is.
	/// Bullet's pools and tables have one owner thread; so has this. `registry` may be shared by several worlds of one thread. A
	/// btCollisionDispatcherMt is refused, too: it calls algorithms from several threads. A world with a btCollisionDispatcher has its
	/// queries shared out by `setQueryThreads`.
	static btISTRegistration registerAlgorithm(
		btCollisionDispatcher* dispatcher, btOverlappingPairCache* pairCache = nullptr, std::shared_ptr<btISTRegistry> registry = nullptr);

	void processCollision(const btCollisionObjectWrapper* body0Wrap, const btCollisionObjectWrapper* body1Wrap,
		const btDispatcherInfo& dispatchInfo, btManifoldResult* resultOut) override;
	btScalar calculateTimeOfImpact(
		btCollisionObject* body0, btCollisionObject* body1, const btDispatcherInfo& dispatchInfo, btManifoldResult* resultOut) override;
	void getAllContactManifolds(btManifoldArray& manifoldArray) override;

private:
	/// One without a tree may be deleted, and its address be given to another.
	struct KnownShape
	{
		const btCollisionShape* shape;
		float scaling[3];
		int type;

		void keep(const btCollisionShape* known);
		bool is(const btCollisionShape* other) const;
		bool isKindOf(const btCollisionShape* other) const;  // whatever its scaling
	};

	void evaluate(const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB, btISTContact& contact) const;
	void update(const btISTPairQuery& query, btISTContact& contact) const;
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
	btCollisionAlgorithm* m_stock = nullptr;  // Bullet's, while it works in place of this
	KnownShape m_A, m_B;
	uint32_t m_version;  // of the registry
};
static_assert(sizeof(btISTCollisionAlgorithm) <= 144, "a pool element has 192 bytes, of which some are left to Bullet's future");
