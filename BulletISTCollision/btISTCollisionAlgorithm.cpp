// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/btISTCollisionAlgorithm.h"

#include "BulletISTCollision/Core/LeafClearance.h"
#include "BulletISTCollision/btISTConversion.h"
#include "BulletISTCollision/btISTContext.h"
#include "BulletISTCollision/btISTRepresentativePoints.h"
#include "BulletISTCollision/btISTShapeField.h"

#include "BulletCollision/BroadphaseCollision/btDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletCollision/CollisionShapes/btCollisionShape.h"

#include <algorithm>
#include <chrono>
#include <utility>

#ifdef BT_USE_DOUBLE_PRECISION
extern const int btISTBuiltForScalarOfSize8 = 8;
#else
extern const int btISTBuiltForScalarOfSize4 = 4;
#endif

btISTCollisionAlgorithm::btISTCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info, std::shared_ptr<btISTContext> context,
												 Mode mode, std::shared_ptr<const ist::InnerSphereTree> treeA,
												 std::shared_ptr<const ist::InnerSphereTree> treeB,
												 const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b)
	: btCollisionAlgorithm(info), m_context(std::move(context)), m_treeA(std::move(treeA)), m_treeB(std::move(treeB)),
	  // Never the manifold in `info`: nested compounds would have several pairs write into it. Kept while separated, too: an empty
	  // manifold is what makes Bullet wake a sleeping body when a kinematic one comes near.
	  m_manifold(m_dispatcher->getNewManifold(a.getCollisionObject(), b.getCollisionObject())),
	  m_contact(mode == Respond ? m_context->store.acquire(m_manifold) : nullptr)
{
	for (int i = 0; i < 3; ++i)
	{
		m_scalingA[i] = float(a.getCollisionShape()->getLocalScaling()[i]);
		m_scalingB[i] = float(b.getCollisionShape()->getLocalScaling()[i]);
	}
}

btISTCollisionAlgorithm::~btISTCollisionAlgorithm()
{
	destroyStock();
	if (m_contact) m_context->store.release(m_manifold);
	m_dispatcher->releaseManifold(m_manifold);
}

ist::OverlapResult btISTCollisionAlgorithm::query(const btISTShapeField& field, btISTContact& contact) const
{
	ist::PairAccuracy& pair = contact.accuracy;
	const double error = m_context->forceErrorOf(contact.bodyA, contact.bodyB);
	const bool accepts = error > 0;
	if (m_treeB && (accepts || pair.level > 0 || pair.fadedShare > 0))
	{
		// What the leaves pressed until now fades out, too.
		if (pair.level < 0 && contact.patchCount > 0 && contact.level == 0) pair.level = 0;
		ist::AcceptedError accepted;
		accepted.error = error;
		accepted.weightA = contact.constants.weightA;  // of the last step
		accepted.weightB = contact.constants.weightB;
		const ist::OverlapResult result = ist::queryPair(*m_treeA, *m_treeB, contact.X_AB, m_context->workspace, accepted, m_context->options(), pair);
		if (!accepts && pair.level <= 0 && pair.fadedShare == 0) pair = ist::PairAccuracy();
		return result;
	}
	pair = ist::PairAccuracy();
	if (m_treeB) return ist::queryOverlap(*m_treeA, *m_treeB, contact.X_AB, m_context->workspace, m_context->options());
	contact.halfSpace = field.isHalfSpace();
	ist::OverlapResult none;
	none.status = ist::QueryStatus::InvalidPose;
	if (!field.field()) return none;  // scaled to nothing since the pair was made
	contact.volumeB = field.field()->volume();
	return ist::queryField(*m_treeA, *field.field(), contact.X_AB * field.X_SF(), m_context->workspace, m_context->options());
}

/// Zero where there is none, or where a query is as cheap, or where balls answered that reach farther than the leaves.
double btISTCollisionAlgorithm::clearance(const btISTShapeField& field, const ist::OverlapResult& result, btISTContact& contact) const
{
	constexpr int kMostOpened = 12;
	if (result.level > 0) return 0;
	if (result.status != ist::QueryStatus::Ok || result.total.pairs > 0 || result.nodeVisits == 0 || !contact.kept.wantsClearance()) return 0;
	if (m_treeB) return ist::leafClearance(*m_treeA, *m_treeB, contact.X_AB, kMostOpened);
	return ist::leafClearance(*m_treeA, *field.field(), contact.X_AB * field.X_SF(), kMostOpened);
}

btISTKeptResult::Measures btISTCollisionAlgorithm::measures(const btISTShapeField& field, const btISTContact& contact) const
{
	if (!m_treeB) return field.measures();
	return {m_context->forceErrorOf(contact.bodyA, contact.bodyB) > 0 ? contact.constants.weightA : 0};
}

/// The sums of `contact` at its X_AB, kept or asked for.
void btISTCollisionAlgorithm::update(const btISTShapeField& field, btISTContact& contact) const
{
	btISTContactStore& store = m_context->store;
	const bool timed = m_contact && store.measuresQueryTime();
	const auto begin = timed ? std::chrono::steady_clock::now() : std::chrono::steady_clock::time_point();
	const auto seconds = [&] { return timed ? std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() : 0.0; };
	const uint64_t version = m_context->optionsVersion();
	const btISTKeptResult::Measures on = measures(field, contact);
	const btISTEconomy& economy = m_context->economy;
	const bool fading = contact.accuracy.fadedShare > 0;  // from one level into another
	const int before = contact.accuracy.level;
	contact.use = m_contact && !fading ? contact.kept.use(contact, on, version, economy) : btISTKeptResult::Ask;
	if (contact.use != btISTKeptResult::Ask) return store.count(contact, nullptr, seconds());

	const ist::OverlapResult result = query(field, contact);
	contact.status = result.status;
	contact.level = result.level;
	const bool good = result.status == ist::QueryStatus::Ok;
	contact.total = good ? result.total : ist::OverlapIntegrals();
	contact.patchCount = good ? std::min(result.patchCount, btISTContact::kMaxPatches) : 0;
	std::copy(result.patches, result.patches + contact.patchCount, contact.patches);
	if (!m_contact) return;
	// Where the level has just changed, or begins to, the next query at the same pose may say something else.
	const bool settled = !fading && contact.accuracy.fadedShare == 0 && contact.accuracy.level == before;
	if (economy.on && settled) contact.kept.keep(contact, on, version, clearance(field, result, contact), economy);
	else contact.kept.forget();
	store.count(contact, &result, seconds());
}

void btISTCollisionAlgorithm::evaluate(const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB,
									   btISTContact& contact) const
{
	contact.bodyA = wrapA->getCollisionObject();
	contact.bodyB = wrapB->getCollisionObject();
	contact.treeA = m_treeA;
	contact.treeB = m_treeB;
	contact.stamp = m_context->store.step();
	contact.X_WA = toPose(wrapA->getWorldTransform());
	contact.X_AB = ist::inverse(contact.X_WA) * toPose(wrapB->getWorldTransform());
	update(m_treeB ? btISTShapeField() : btISTShapeField(wrapB->getCollisionShape()), contact);

	std::fill(contact.impulses, contact.impulses + btISTContact::kMaxPatches, ist::Wrench());
	contact.normalImpulse = 0;
	contact.work = btISTContactWork();
	if (contact.patchCount == 0) contact.ledger = btISTContactLedger();
	contact.constants = m_context->rule->decide(contact, contact.bodyA, contact.bodyB);
	contact.error = ist::OverlapError();
	const double gap = m_treeA->errorLength() + (m_treeB ? m_treeB->errorLength() : 0);
	if (contact.total.volume > 0) contact.error = ist::overlapError(contact.total, gap, contact.constants.k);
}

void btISTCollisionAlgorithm::processCollision(const btCollisionObjectWrapper* body0Wrap, const btCollisionObjectWrapper* body1Wrap,
											   const btDispatcherInfo& dispatchInfo, btManifoldResult* resultOut)
{
	const bool was = !m_stock && m_contact && m_contact->stamp > 0;
	if (isScaled(*body0Wrap, *body1Wrap) || !m_context->watch.covers(*body0Wrap, *body1Wrap, was))
	{
		if (!m_stock) createStock(body0Wrap, body1Wrap);
		return m_stock->processCollision(body0Wrap, body1Wrap, dispatchInfo, resultOut);
	}
	destroyStock();
	resultOut->setPersistentManifold(m_manifold);
	const bool swapped = body0Wrap->getCollisionObject() != m_manifold->getBody0();
	const btCollisionObjectWrapper* wrapA = swapped ? body1Wrap : body0Wrap;
	const btCollisionObjectWrapper* wrapB = swapped ? body0Wrap : body1Wrap;
	if (m_contact)
	{
		evaluate(wrapA, wrapB, *m_contact);
		btISTRepresentativePoints(*m_contact).write(*m_manifold, m_contact->constants.dissipation, wrapA, wrapB);
		return;
	}
	btISTContact contact;
	evaluate(wrapA, wrapB, contact);
	btISTRepresentativePoints(contact).report(*resultOut);
}

/// Whether a shape with a tree was scaled since the pair was made.
bool btISTCollisionAlgorithm::isScaled(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1) const
{
	const bool swapped = body0.getCollisionObject() != m_manifold->getBody0();
	const auto isKept = [](const btCollisionObjectWrapper& w, const float* s)
	{ return btISTRegistry::hasScaling(*w.getCollisionShape(), btVector3(btScalar(s[0]), btScalar(s[1]), btScalar(s[2]))); };
	return !isKept(swapped ? body1 : body0, m_scalingA) || (m_treeB && !isKept(swapped ? body0 : body1, m_scalingB));
}

void btISTCollisionAlgorithm::createStock(const btCollisionObjectWrapper* body0Wrap, const btCollisionObjectWrapper* body1Wrap)
{
	m_manifold->clearManifold();
	if (m_contact)
	{
		m_contact->total = ist::OverlapIntegrals();
		m_contact->patchCount = 0;
		m_contact->normalImpulse = 0;
		m_contact->work = btISTContactWork();
		m_contact->ledger = btISTContactLedger();
		m_contact->accuracy = ist::PairAccuracy();
		m_contact->kept.forget();
	}
	btCollisionAlgorithmConstructionInfo info;  // without a manifold: the other constructor leaves it to chance
	info.m_dispatcher1 = m_dispatcher;
	btISTCreateFunc& ours = m_context->function(!m_contact);
	const int type0 = body0Wrap->getCollisionShape()->getShapeType(), type1 = body1Wrap->getCollisionShape()->getShapeType();
	m_stock = ours.previous[type0][type1]->CreateCollisionAlgorithm(info, body0Wrap, body1Wrap);
}

void btISTCollisionAlgorithm::destroyStock()
{
	if (!m_stock) return;
	m_stock->~btCollisionAlgorithm();
	m_dispatcher->freeCollisionAlgorithm(m_stock);
	m_stock = nullptr;
}

btScalar btISTCollisionAlgorithm::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&, btManifoldResult*)
{
	return btScalar(1);  // Bullet sweeps convex shapes itself; this is asked for only in DISPATCH_CONTINUOUS
}

void btISTCollisionAlgorithm::getAllContactManifolds(btManifoldArray& manifoldArray)
{
	if (m_contact) manifoldArray.push_back(m_manifold);
	if (m_stock) m_stock->getAllContactManifolds(manifoldArray);
}
