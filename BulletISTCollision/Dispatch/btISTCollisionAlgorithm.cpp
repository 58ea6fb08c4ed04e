// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include "BulletISTCollision/Contact/btISTRepresentativePoints.h"
#include "BulletISTCollision/Dispatch/btISTContext.h"
#include "BulletISTCollision/Dispatch/btISTQueryThreads.h"
#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"
#include "BulletISTCollision/Registry/btISTClassOf.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "BulletISTCollision/Registry/btISTShapeField.h"

#include "BulletCollision/BroadphaseCollision/btDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletCollision/CollisionShapes/btCollisionShape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#ifdef BT_USE_DOUBLE_PRECISION
extern const int btISTBuiltForScalarOfSize8 = 8;
#else
extern const int btISTBuiltForScalarOfSize4 = 4;
#endif

namespace
{
/// Depth of the deepest patch [m]: volume over area. Where a patch presses from two sides, their areas cancel, and twice the mean of the
/// depth within the bodies is less.
double depthOf(const btISTContact& contact)
{
	double deepest = 0;
	for (int i = 0; i < contact.patchCount; ++i)
	{
		const ist::OverlapIntegrals& patch = contact.patches[i];
		const double inside = contact.constants.weightA * patch.depthA + contact.constants.weightB * patch.depthB;
		if (patch.volume > 0) deepest = std::max(deepest, std::min(ist::meanDepth(patch), 2 * inside / patch.volume));
	}
	return deepest;
}

/// Whether the shape is the body's own. A child of a compound is not: its parent gives it another transform.
bool isBody(const btCollisionObjectWrapper& wrap) { return &wrap.getWorldTransform() == &wrap.getCollisionObject()->getWorldTransform(); }

/// Whether the axes of a body are too far from unit length and right angles. Trees describe rigid bodies only. A transform with values
/// that are not finite is not skewed.
bool isSkewed(const btCollisionObjectWrapper& wrap)
{
	const ist::Pose X = toRigidPose(wrap.getWorldTransform());
	return !isRigid(X) && isFinite(X.translation) &&
		std::isfinite(squaredNorm(X.rotation.row(0)) + squaredNorm(X.rotation.row(1)) + squaredNorm(X.rotation.row(2)));
}

/// True within a contact test, where Bullet lets Respond algorithms answer for the children of a compound. Games may pass result classes of
/// their own, so it does not suffice that the result is no plain btManifoldResult.
bool isOfContactTest(const btManifoldResult& result, const btISTContext& context)
{
	return btISTVirtualTable(&result) == context.tableOfContactTests;
}

void announceProcessed(btPersistentManifold& manifold)
{
	if (!gContactProcessedCallback) return;
	for (int i = 0; i < manifold.getNumContacts(); ++i)
		gContactProcessedCallback(manifold.getContactPoint(i), const_cast<btCollisionObject*>(manifold.getBody0()),
			const_cast<btCollisionObject*>(manifold.getBody1()));
}
}  // namespace

btISTCollisionAlgorithm::btISTCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info, std::shared_ptr<btISTContext> context,
	Mode mode, std::shared_ptr<const ist::InnerSphereTree> treeA, std::shared_ptr<const ist::InnerSphereTree> treeB,
	const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b)
	: btCollisionAlgorithm(info),
	  m_context(std::move(context)),
	  m_treeA(std::move(treeA)),
	  m_treeB(std::move(treeB)),
	  // The manifold in `info` is never used: with nested compounds several pairs would write into it. This manifold is kept while the
	  // bodies are separated, too: an empty manifold makes Bullet wake a sleeping body when a kinematic one approaches.
	  m_manifold(m_dispatcher->getNewManifold(a.getCollisionObject(), b.getCollisionObject())),
	  m_contact(mode == Respond ? m_context->store.acquire(m_manifold) : nullptr)
{
	keepShapes(a.getCollisionShape(), b.getCollisionShape());
}

void btISTCollisionAlgorithm::keepShapes(const btCollisionShape* shapeA, const btCollisionShape* shapeB)
{
	m_version = uint32_t(m_context->registry->version());
	m_A.keep(shapeA);
	m_B.keep(shapeB);
	if (!m_contact) return;
	m_contact->shapeA = shapeA;
	m_contact->shapeB = shapeB;
}

void btISTCollisionAlgorithm::KnownShape::keep(const btCollisionShape* known)
{
	shape = known;
	type = known->getShapeType();
	for (int i = 0; i < 3; ++i) scaling[i] = float(known->getLocalScaling()[i]);
}

bool btISTCollisionAlgorithm::KnownShape::is(const btCollisionShape* other) const
{
	return isKindOf(other) &&
		btISTRegistry::hasScaling(*other, btVector3(btScalar(scaling[0]), btScalar(scaling[1]), btScalar(scaling[2])));
}

bool btISTCollisionAlgorithm::KnownShape::isKindOf(const btCollisionShape* other) const
{
	return other == shape && other->getShapeType() == type;
}

/// Checks the shapes and trees again if a shape is another one, or if the registry has changed. Without a registration, unchanged shapes
/// keep their trees.
void btISTCollisionAlgorithm::see(const btCollisionShape* shapeA, const btCollisionShape* shapeB)
{
	// A closed form takes its size from the shape in every step, so its scaling may change.
	const bool same = m_A.is(shapeA) && (m_treeA && !m_treeB ? m_B.isKindOf(shapeB) : m_B.is(shapeB));
	if (same && (!m_context->active || m_version == uint32_t(m_context->registry->version()))) return;
	const btISTRegistry& registry = *m_context->registry;
	auto treeA = registry.find(shapeA), treeB = registry.find(shapeB);
	// If A has no tree, Bullet handles the pair: the order of the manifold cannot change.
	const bool known = treeB || (!registry.isAttached(shapeB) && btISTShapeField(shapeB).field());
	if (!known) treeA.reset();
	if (!same || treeA != m_treeA || treeB != m_treeB)
	{
		forget();
		destroyStock();
	}
	m_treeA = std::move(treeA);
	m_treeB = std::move(treeB);
	keepShapes(shapeA, shapeB);
}

btISTCollisionAlgorithm::~btISTCollisionAlgorithm()
{
	destroyStock();
	if (m_contact) m_context->store.release(m_manifold);
	m_dispatcher->releaseManifold(m_manifold);
}

/// Updates the sums of `contact` at its X_AB, from the prefetched result or by a query now.
void btISTCollisionAlgorithm::update(const btISTPairQuery& query, btISTContact& contact) const
{
	btISTContactStore& store = m_context->store;
	const bool kept = &contact == m_contact;
	btISTQueryWork work;
	if (!kept || !m_context->threads || !m_context->threads->takeResult(contact, work))
		work = query.answer(contact, m_context->workspace, kept && store.measuresQueryTime());
	if (kept) store.count(contact, work.asked ? &work.result : nullptr, work.seconds);
}

/// Looks for what the step brings to bodies that are apart, along their free motion. Else, or where they touch too little to stop each
/// other, supposes that others hold one of them: a link that is caught, or the lowest body of a stack, stops its neighbours in the same
/// step.
void btISTCollisionAlgorithm::predictTouch(const btISTPairQuery& query, double step, btISTContact& contact) const
{
	const btISTBodyMotion a = btISTBodyMotion::free(contact.bodyA, step), b = btISTBodyMotion::free(contact.bodyB, step);
	const bool apart = contact.patchCount == 0;
	if (apart) contact.touchMissed = !btISTFirstTouch(query, a, b, step).find(contact, m_context->workspace);
	if (contact.ahead > 0) return;
	m_context->clusters.beginStep(m_context->store, step);
	for (const bool isA : {true, false})
	{
		const ist::Vec3* velocity = m_context->clusters.velocityOf(isA ? *contact.bodyA : *contact.bodyB);
		const double change = velocity ? step * distance(*velocity, (isA ? a : b).twist.linear) : 0;
		if (contact.ahead > 0 || !(change > btISTFirstTouch::kWorthLooking * contact.thickness())) continue;
		btISTBodyMotion heldA = a, heldB = b;
		(isA ? heldA : heldB).twist.linear = *velocity;
		const btISTFirstTouch touch(query, heldA, heldB, step);
		if (!apart) touch.findFurther(contact, m_context->later, m_context->workspace);
		else if (!touch.find(contact, m_context->workspace)) contact.touchMissed = true;
		if (!(contact.ahead > 0)) continue;
		contact.supposedA = heldA.twist - a.twist;
		contact.supposedB = heldB.twist - b.twist;
	}
}

void btISTCollisionAlgorithm::evaluate(
	const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB, double step, btISTContact& contact) const
{
	contact.bodyA = wrapA->getCollisionObject();
	contact.bodyB = wrapB->getCollisionObject();
	// The comparison avoids the atomic reference count of an assignment.
	if (contact.treeA != m_treeA) contact.treeA = m_treeA;
	if (contact.treeB != m_treeB) contact.treeB = m_treeB;
	contact.stamp = m_context->store.step();
	contact.X_WA = toRigidPose(wrapA->getWorldTransform());
	contact.X_AB = ist::inverse(contact.X_WA) * toRigidPose(wrapB->getWorldTransform());
	contact.startX_WA = contact.X_WA;
	contact.startX_AB = contact.X_AB;
	contact.canPrefetch = isBody(*wrapA) && isBody(*wrapB);
	const btISTShapeField field = m_treeB ? btISTShapeField() : btISTShapeField(wrapB->getCollisionShape());
	const bool kept = &contact == m_contact;
	const btISTPairQuery query(field, m_context->rules, kept, kept && m_context->store.sumsDamping());
	const ist::AdaptiveLevel before = contact.accuracy;
	update(query, contact);

	std::fill(contact.impulses, contact.impulses + btISTContact::kMaxPatches, ist::Wrench());
	contact.normalImpulse = 0;
	contact.touchMissed = false;
	contact.supposedA = contact.supposedB = {};
	contact.deflected = false;
	contact.work = btISTContactWork();
	if (contact.patchCount == 0)
	{
		contact.tank = btISTContactEnergyTank();
		contact.pressed = {};
		contact.grown = 0;
		contact.growth = {};
	}
	if (kept && m_context->store.predictsTouch() && contact.status == ist::QueryStatus::Ok) predictTouch(query, step, contact);
	if (contact.touchMissed) m_context->store.countMissedTouch();
	contact.constants = m_context->rule->decide(contact, contact.bodyA, contact.bodyB);
	if (!m_context->store.raisesStiffness()) setStiffnessForArea(contact);
	if (query.lacksDamping(contact))  // the sums used the constants of the last step
	{
		if (contact.ahead > 0) query.queryAt(contact, m_context->workspace);
		else
		{
			contact.kept.forget();
			contact.accuracy = before;
			update(query, contact);
		}
	}
	contact.depth = depthOf(contact);
	contact.deepest = std::max(contact.deepest, contact.depth);
	btISTPairQuery::judge(contact);
}

void btISTCollisionAlgorithm::processCollision(const btCollisionObjectWrapper* body0Wrap, const btCollisionObjectWrapper* body1Wrap,
	const btDispatcherInfo& dispatchInfo, btManifoldResult* resultOut)
{
	const bool swapped = body0Wrap->getCollisionObject() != m_manifold->getBody0();
	const btCollisionObjectWrapper* wrapA = swapped ? body1Wrap : body0Wrap;
	const btCollisionObjectWrapper* wrapB = swapped ? body0Wrap : body1Wrap;
	const btCollisionShape *shapeA = wrapA->getCollisionShape(), *shapeB = wrapB->getCollisionShape();
	see(shapeA, shapeB);
	const bool was = !m_stock && m_contact && m_contact->stamp > 0;
	if (!m_treeA || isSkewed(*wrapA) || isSkewed(*wrapB) || !m_context->pairFilter.accepts(*body0Wrap, *body1Wrap, was))
	{
		if (!m_stock) createStock(body0Wrap, body1Wrap);
		return m_stock->processCollision(body0Wrap, body1Wrap, dispatchInfo, resultOut);
	}
	destroyStock();
	resultOut->setPersistentManifold(m_manifold);
	if (!m_contact || isOfContactTest(*resultOut, *m_context))
	{
		if (report(wrapA, wrapB, *resultOut) || !(resultOut->m_closestPointDistanceThreshold > 0)) return;
		createStock(body0Wrap, body1Wrap);  // the bodies are apart, and the caller wants their distance
		m_stock->processCollision(body0Wrap, body1Wrap, dispatchInfo, resultOut);
		return destroyStock();
	}
	if (m_context->threads) m_context->threads->begin(*m_contact, m_context->store, m_context->rules, m_context->workspace, *m_dispatcher);
	evaluate(wrapA, wrapB, double(dispatchInfo.m_timeStep), *m_contact);
	// The list serves the next step: a prefetched query could not use a list that is assigned in the pair's own turn.
	if (m_context->memories) m_context->memories->assign(*m_contact);
	btISTRepresentativePoints(*m_contact).write(*m_manifold, m_contact->constants.dissipation, wrapA, wrapB);
	// Bullet itself announces the manifolds of a compound's children, in their state of one step before.
	if (m_contact->canPrefetch) announceProcessed(*m_manifold);
}

/// Reports the contact to a contact test. Returns whether there is overlap. The cached result of the pair does not change.
bool btISTCollisionAlgorithm::report(
	const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB, btManifoldResult& out) const
{
	btISTContact contact;
	evaluate(wrapA, wrapB, 0, contact);
	const btISTRepresentativePoints points(contact);
	points.report(out);
	return points.count > 0;
}

/// Forgets the state of the contact and its points.
void btISTCollisionAlgorithm::forget()
{
	m_manifold->clearManifold();
	if (!m_contact) return;
	m_contact->halfSpace = false;
	m_contact->volumeB = std::numeric_limits<double>::infinity();
	m_contact->total = ist::OverlapIntegrals();
	m_contact->patchCount = 0;
	m_contact->pressed = {};
	m_contact->growth = {};
	m_contact->normalImpulse = m_contact->grown = m_contact->ahead = 0;
	m_contact->depth = m_contact->deepest = 0;  // the next shapes may have another thickness
	m_contact->work = btISTContactWork();
	m_contact->tank = btISTContactEnergyTank();
	m_contact->accuracy = ist::AdaptiveLevel();
	m_contact->kept.forget();
	m_contact->memory.reset();
	if (m_context->threads) m_context->threads->release(*m_contact);
}

void btISTCollisionAlgorithm::createStock(const btCollisionObjectWrapper* body0Wrap, const btCollisionObjectWrapper* body1Wrap)
{
	forget();
	btCollisionAlgorithmConstructionInfo info;  // an explicit empty manifold: the constructor with arguments leaves it uninitialised
	info.m_dispatcher1 = m_dispatcher;
	const int type0 = body0Wrap->getCollisionShape()->getShapeType(), type1 = body1Wrap->getCollisionShape()->getShapeType();
	m_stock = m_context->function(!m_contact).delegate(info, body0Wrap, body1Wrap, type0, type1);
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
	return btScalar(1);  // Bullet sweeps convex shapes itself; it calls this only in DISPATCH_CONTINUOUS
}

void btISTCollisionAlgorithm::getAllContactManifolds(btManifoldArray& manifoldArray)
{
	if (m_contact) manifoldArray.push_back(m_manifold);
	if (m_stock) m_stock->getAllContactManifolds(manifoldArray);
}
