// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/btISTCollisionAlgorithm.h"

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"
#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#ifdef BT_USE_DOUBLE_PRECISION
extern const int btISTBuiltForScalarOfSize8 = 8;
#else
extern const int btISTBuiltForScalarOfSize4 = 4;
#endif

namespace
{
constexpr int kTypes = MAX_BROADPHASE_COLLISION_TYPES;

// Points deeper than 0.04 (btContactSolverInfo::m_splitImpulsePenetrationThreshold) are taken out of the velocity solve, and a
// heavy body then falls through. Deeper contact is written with this distance and the stiffness that gives the same force.
constexpr double kDeepestDistance = 0.03;  // [m]
// Patches that push within this angle of each other become one group; four points of one normal ignore 6 % of the force at most.
const double kSameDirection = std::cos(20 * M_PI / 180);
// Hunt-Crossley dissipation of the representative points [s/m].
constexpr double kDissipation = 1;

ist::Vec3 toVec3(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }
btVector3 toBullet(const ist::Vec3& v) { return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)); }

ist::Pose toPose(const btTransform& t)
{
	ist::Pose X;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) X.rotation.m[i][j] = double(t.getBasis()[i][j]);
	X.translation = toVec3(t.getOrigin());
	return X;
}

/// One point that stands for a share of the contact: World axes; `normal` points from B to A.
struct RepresentativePoint
{
	ist::Vec3 position, normal;
	double force = 0, stiffness = 0;  // [N], [N/m]
	double depth() const { return force / stiffness; }
};

struct RepresentativePoints
{
	RepresentativePoint point[MANIFOLD_CACHE_SIZE];
	int count = 0;
};

/// Patches that push in about the same direction, A's mesh frame.
struct PatchGroup
{
	ist::OverlapIntegrals sums;
	ist::Wrench wrench;  // about A's origin
	double strength = 0;  // |force|
};

class PatchGroups
{
public:
	explicit PatchGroups(const btISTContact& contact)
		: m_pair{contact.stiffness.k, contact.stiffness.weightA, contact.stiffness.weightB}
	{
		for (int i = 0; i < contact.patchCount; ++i) add(contact.patches[i]);
		while (m_count > MANIFOLD_CACHE_SIZE) mergeWeakest();
	}
	int count() const { return m_count; }
	const PatchGroup& operator[](int i) const { return m_group[i]; }
	const ist::PressurePair& pair() const { return m_pair; }

private:
	void refresh(PatchGroup& g) const
	{
		g.wrench = ist::pressureWrench(g.sums, m_pair);
		g.strength = ist::norm(g.wrench.force);
	}

	int closest(const PatchGroup& g, int except, double& cosine) const
	{
		int best = -1;
		cosine = -2;
		for (int i = 0; i < m_count; ++i)
		{
			const double c = ist::dot(ist::normalized(m_group[i].wrench.force), ist::normalized(g.wrench.force));
			if (i != except && c > cosine) best = i, cosine = c;
		}
		return best;
	}

	void add(const ist::OverlapIntegrals& patch)
	{
		PatchGroup g;
		g.sums = patch;
		refresh(g);
		if (!(g.strength > 0) || !(g.sums.volume > 0)) return;
		double cosine;
		const int near = closest(g, -1, cosine);
		if (near < 0 || cosine < kSameDirection)
		{
			m_group[m_count++] = g;
			return;
		}
		m_group[near].sums.add(patch);
		refresh(m_group[near]);
	}

	void mergeWeakest()
	{
		int weakest = 0;
		for (int i = 1; i < m_count; ++i)
			if (m_group[i].strength < m_group[weakest].strength) weakest = i;
		double cosine;
		const int into = closest(m_group[weakest], weakest, cosine);
		m_group[into].sums.add(m_group[weakest].sums);
		refresh(m_group[into]);
		m_group[weakest] = m_group[--m_count];
	}

	ist::PressurePair m_pair;
	PatchGroup m_group[btISTContact::kMaxPatches];
	int m_count = 0;
};

/// A group seen from its own plane: centre, normal, in-plane axes, second moments of the overlap in them; A's mesh frame.
struct GroupPlane
{
	ist::Vec3 center, normal, t1, t2;
	double xx = 0, xy = 0, yy = 0;  // [m^2]
	double force = 0, stiffness = 0;
	double moment1 = 0, moment2 = 0;  // about `center`, along t1 and t2

	GroupPlane(const PatchGroup& g, const ist::PressurePair& pair, const ist::Vec3& origin)
	{
		const ist::Vec3 c = g.sums.firstMoment / g.sums.volume;
		center = origin + c;
		normal = ist::normalized(g.wrench.force);
		force = g.strength;
		ist::completeFrame(normal, t1, t2);
		const double* s = g.sums.secondMoment;
		const ist::Mat3 second{{{s[0], s[3], s[4]}, {s[3], s[1], s[5]}, {s[4], s[5], s[2]}}};
		const auto covariance = [&](const ist::Vec3& u, const ist::Vec3& v)
		{ return ist::dot(u, second * v) / g.sums.volume - ist::dot(u, c) * ist::dot(v, c); };
		xx = std::max(covariance(t1, t1), 0.0);
		yy = std::max(covariance(t2, t2), 0.0);
		xy = covariance(t1, t2);
		const ist::Vec3 moment = g.wrench.torque - ist::cross(c, g.wrench.force);
		moment1 = ist::dot(moment, t1);
		moment2 = ist::dot(moment, t2);

		const ist::SymmetricMatrix6 K = ist::pressureStiffness(g.sums, pair);
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) stiffness += normal[i] * K(i, j) * normal[j];
		// Deep contact may soften; a point needs a spring all the same.
		const double least = 0.1 * pair.stiffness * ist::norm(g.sums.areaVector);
		if (!(stiffness > least)) stiffness = least;
	}
};

void append(RepresentativePoints& out, const GroupPlane& g, const ist::Pose& X_WA, double x, double y, double force, double stiffness)
{
	if (!(stiffness > 0) || !(force >= 0) || out.count >= MANIFOLD_CACHE_SIZE) return;
	RepresentativePoint& p = out.point[out.count++];
	p.position = X_WA * (g.center + x * g.t1 + y * g.t2);
	p.normal = X_WA.rotation * g.normal;
	p.force = force;
	p.stiffness = stiffness;
}

// Four points at the centre +- the columns of S, S S^T = 2 covariance, a quarter of the stiffness each: total, first and second
// moments are exact (reference/stability.md 1.6). The symmetric root, rather than principal axes, does not spin when the
// overlap is nearly isotropic. Forces: the quarter plus the antisymmetric part that makes the moment, never negative.
void appendFour(RepresentativePoints& out, const GroupPlane& g, const ist::Pose& X_WA)
{
	const double root = std::sqrt(std::max(g.xx * g.yy - g.xy * g.xy, 0.0));
	const double trace = std::sqrt(g.xx + g.yy + 2 * root);
	const double scale = trace > 0 ? std::sqrt(2.0) / trace : 0;
	const double x1 = scale * (g.xx + root), y1 = scale * g.xy, x2 = y1, y2 = scale * (g.yy + root);
	const double determinant = x1 * y2 - x2 * y1;
	const double quarter = g.force / 4;
	double f1 = 0, f2 = 0;
	if (determinant > 1e-12 * (x1 * x1 + y2 * y2))
	{
		// sum f y = moment1, -sum f x = moment2
		f1 = (-g.moment2 * y2 - g.moment1 * x2) / (2 * determinant);
		f2 = (g.moment1 * x1 + g.moment2 * y1) / (2 * determinant);
	}
	f1 = std::clamp(f1, -quarter, quarter);
	f2 = std::clamp(f2, -quarter, quarter);
	append(out, g, X_WA, x1, y1, quarter + f1, g.stiffness / 4);
	append(out, g, X_WA, -x1, -y1, quarter - f1, g.stiffness / 4);
	append(out, g, X_WA, x2, y2, quarter + f2, g.stiffness / 4);
	append(out, g, X_WA, -x2, -y2, quarter - f2, g.stiffness / 4);
}

// Two points on the longer principal axis; the moment about the other one is lost.
void appendTwo(RepresentativePoints& out, const GroupPlane& g, const ist::Pose& X_WA)
{
	const double mean = (g.xx + g.yy) / 2, half = (g.xx - g.yy) / 2;
	const double angle = 0.5 * std::atan2(g.xy, half);
	const double length = std::sqrt(mean + std::hypot(half, g.xy));
	const double x = length * std::cos(angle), y = length * std::sin(angle);
	double f = length > 0 ? (g.moment1 * std::sin(angle) - g.moment2 * std::cos(angle)) / (2 * length) : 0;
	f = std::clamp(f, -g.force / 2, g.force / 2);
	append(out, g, X_WA, x, y, g.force / 2 + f, g.stiffness / 2);
	append(out, g, X_WA, -x, -y, g.force / 2 - f, g.stiffness / 2);
}

// Beyond the medial axis the field's force vanishes while the bodies still overlap: a contact test must say so all the same.
void appendTouch(RepresentativePoints& out, const btISTContact& contact)
{
	ist::Vec3 normal = ist::normalized(contact.total.areaVector);
	if (ist::norm(normal) == 0) normal = {0, 0, 1};
	RepresentativePoint& p = out.point[out.count++];
	p.position = contact.X_WA * (contact.treeA->origin + contact.total.firstMoment / contact.total.volume);
	p.normal = contact.X_WA.rotation * normal;
	p.force = 0;
	p.stiffness = contact.stiffness.k * std::cbrt(contact.total.volume * contact.total.volume);
}

RepresentativePoints representativePoints(const btISTContact& contact)
{
	RepresentativePoints points;
	const PatchGroups groups(contact);
	for (int i = 0; i < groups.count(); ++i)
	{
		const GroupPlane plane(groups[i], groups.pair(), contact.treeA->origin);
		if (groups.count() == 1)
			appendFour(points, plane, contact.X_WA);
		else if (groups.count() == 2)
			appendTwo(points, plane, contact.X_WA);
		else
			append(points, plane, contact.X_WA, 0, 0, plane.force, plane.stiffness);
	}
	if (points.count == 0 && contact.total.volume > 0) appendTouch(points, contact);
	return points;
}

/// Bullet's point for `p`; the positions on both bodies lie half the depth to either side.
btManifoldPoint manifoldPoint(const RepresentativePoint& p, const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB)
{
	const double depth = std::min(p.depth(), kDeepestDistance);
	const btCollisionObject* a = wrapA->getCollisionObject();
	const btCollisionObject* b = wrapB->getCollisionObject();
	const btVector3 onA = toBullet(p.position - (depth / 2) * p.normal), onB = toBullet(p.position + (depth / 2) * p.normal);
	btManifoldPoint m(a->getWorldTransform().invXform(onA), b->getWorldTransform().invXform(onB), toBullet(p.normal), btScalar(-depth));
	m.m_positionWorldOnA = onA;
	m.m_positionWorldOnB = onB;
	m.m_partId0 = wrapA->m_partId;
	m.m_index0 = wrapA->m_index;
	m.m_partId1 = wrapB->m_partId;
	m.m_index1 = wrapB->m_index;
	m.m_combinedFriction = btManifoldResult::calculateCombinedFriction(a, b);
	m.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(a, b);
	m.m_combinedRollingFriction = btManifoldResult::calculateCombinedRollingFriction(a, b);
	m.m_combinedSpinningFriction = btManifoldResult::calculateCombinedSpinningFriction(a, b);
	btPlaneSpace1(m.m_normalWorldOnB, m.m_lateralFrictionDir1, m.m_lateralFrictionDir2);
	m.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
	m.m_combinedContactStiffness1 = btScalar(depth > 0 ? p.force / depth : p.stiffness);
	m.m_combinedContactDamping1 = btScalar(kDissipation * p.force);
	return m;
}

/// For each point of the manifold the nearest new one that is still free, or -1.
void matchPoints(const btPersistentManifold& manifold, const btManifoldPoint* points, int count, int (&slotOf)[MANIFOLD_CACHE_SIZE])
{
	bool taken[MANIFOLD_CACHE_SIZE] = {};
	std::fill(slotOf, slotOf + MANIFOLD_CACHE_SIZE, -1);
	for (int round = 0; round < std::min(count, manifold.getNumContacts()); ++round)
	{
		int bestPoint = -1, bestSlot = -1;
		btScalar best = BT_LARGE_FLOAT;
		for (int i = 0; i < count; ++i)
			for (int slot = 0; slot < manifold.getNumContacts(); ++slot)
			{
				if (slotOf[i] >= 0 || taken[slot]) continue;
				const btScalar d = manifold.getContactPoint(slot).m_localPointA.distance2(points[i].m_localPointA);
				if (bestPoint >= 0 && d >= best) continue;
				best = d;
				bestPoint = i;
				bestSlot = slot;
			}
		slotOf[bestPoint] = bestSlot;
		taken[bestSlot] = true;
	}
}

void announceAdded(btPersistentManifold& manifold, int slot, const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB)
{
	const int flags = wrapA->getCollisionObject()->getCollisionFlags() | wrapB->getCollisionObject()->getCollisionFlags();
	if (!gContactAddedCallback || !(flags & btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK)) return;
	btManifoldPoint& p = manifold.getContactPoint(slot);
	(*gContactAddedCallback)(p, wrapA, p.m_partId0, p.m_index0, wrapB, p.m_partId1, p.m_index1);
}

// In place: clearing would tell games that contact ended and began again, and would lose warm starting and their own pointers.
void writeManifold(btPersistentManifold& manifold, const RepresentativePoints& points, const btCollisionObjectWrapper* wrapA,
				   const btCollisionObjectWrapper* wrapB)
{
	btManifoldPoint fresh[MANIFOLD_CACHE_SIZE];
	for (int i = 0; i < points.count; ++i) fresh[i] = manifoldPoint(points.point[i], wrapA, wrapB);
	int slotOf[MANIFOLD_CACHE_SIZE];
	const bool begins = manifold.getNumContacts() == 0 && points.count > 0;
	matchPoints(manifold, fresh, points.count, slotOf);

	bool used[MANIFOLD_CACHE_SIZE] = {};
	for (int i = 0; i < points.count; ++i)
	{
		if (slotOf[i] < 0) continue;
		manifold.replaceContactPoint(fresh[i], slotOf[i]);
		++manifold.getContactPoint(slotOf[i]).m_lifeTime;
		used[slotOf[i]] = true;
		announceAdded(manifold, slotOf[i], wrapA, wrapB);
	}
	// From the back: removal moves the last point into the gap.
	for (int slot = manifold.getNumContacts() - 1; slot >= 0; --slot)
		if (!used[slot]) manifold.removeContactPoint(slot);
	for (int i = 0; i < points.count; ++i)
		if (slotOf[i] < 0) announceAdded(manifold, manifold.addManifoldPoint(fresh[i]), wrapA, wrapB);
	if (begins && gContactStartedCallback) gContactStartedCallback(&manifold);
}

// The result sorts its bodies by the manifold, and expects normal and position in the manifold's order.
void reportPoints(const RepresentativePoints& points, btManifoldResult& out)
{
	for (int i = 0; i < points.count; ++i)
	{
		const RepresentativePoint& p = points.point[i];
		out.addContactPoint(toBullet(p.normal), toBullet(p.position + (p.depth() / 2) * p.normal), btScalar(-p.depth()));
	}
}

bool containsShape(const btCollisionShape* root, const btCollisionShape* shape)
{
	if (root == shape) return true;
	if (!root || !root->isCompound()) return false;
	const auto* compound = static_cast<const btCompoundShape*>(root);
	for (int i = 0; i < compound->getNumChildShapes(); ++i)
		if (containsShape(compound->getChildShape(i), shape)) return true;
	return false;
}

/// The tables are protected and have no getter; a member pointer named through a derived class may read them on any dispatcher.
struct DispatchTables : btCollisionDispatcher
{
	static btCollisionAlgorithmCreateFunc*& entry(btCollisionDispatcher& d, bool closest, int i, int j)
	{
		const auto table = closest ? &DispatchTables::m_doubleDispatchClosestPoints : &DispatchTables::m_doubleDispatchContactPoints;
		return (d.*table)[i][j];
	}
};

template <class Visit>
void forEachEntry(Visit visit)
{
	for (int i = 0; i < kTypes; ++i)
		for (int j = 0; j < kTypes; ++j)
		{
			if (i == SOFTBODY_SHAPE_PROXYTYPE || j == SOFTBODY_SHAPE_PROXYTYPE) continue;
			visit(false, i, j);
			visit(true, i, j);
		}
}

/// One for each table: it finds out from the shapes for which entry it was called.
struct CreateFunc : btCollisionAlgorithmCreateFunc
{
	btISTContext* context = nullptr;
	bool closest = false;
	btCollisionAlgorithmCreateFunc* previous[kTypes][kTypes] = {};

	btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* wrap0,
												   const btCollisionObjectWrapper* wrap1) override;
};
}  // namespace

/// What algorithms need, for as long as one of them or a registration lives.
class btISTContext : public std::enable_shared_from_this<btISTContext>
{
public:
	btISTContext()
	{
		contacts.context = closest.context = this;
		closest.closest = true;
	}
	CreateFunc& function(bool ofClosest) { return ofClosest ? closest : contacts; }

	CreateFunc contacts, closest;
	bool active = true;
	btISTContactStore store;
	std::shared_ptr<btISTRegistry> registry;
	std::shared_ptr<const btISTStiffnessRule> rule = std::make_shared<btISTDefaultStiffnessRule>();
	ist::QueryWorkspace workspace;
	std::weak_ptr<btISTInstallation> installation;
};

btCollisionAlgorithm* CreateFunc::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* wrap0,
														   const btCollisionObjectWrapper* wrap1)
{
	const btCollisionShape* shape0 = wrap0->getCollisionShape();
	const btCollisionShape* shape1 = wrap1->getCollisionShape();
	if (context->active && context->registry->size() > 0)
	{
		auto treeA = context->registry->find(shape0);
		auto treeB = context->registry->find(shape1);
		const bool volumetric = (treeA && treeB) || (treeA && shape1->getShapeType() == STATIC_PLANE_PROXYTYPE) ||
								(treeB && shape0->getShapeType() == STATIC_PLANE_PROXYTYPE);
		if (volumetric)
		{
			const bool swapped = !treeA;  // A has the tree
			if (swapped) std::swap(treeA, treeB);
			const auto mode = closest ? btISTCollisionAlgorithm::Query : btISTCollisionAlgorithm::Respond;
			void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(int(sizeof(btISTCollisionAlgorithm)));
			return new (memory) btISTCollisionAlgorithm(info, context->shared_from_this(), mode, std::move(treeA), std::move(treeB),
														(swapped ? wrap1 : wrap0)->getCollisionObject(),
														(swapped ? wrap0 : wrap1)->getCollisionObject());
		}
	}
	return previous[shape0->getShapeType()][shape1->getShapeType()]->CreateCollisionAlgorithm(info, wrap0, wrap1);
}

/// Our entries in one dispatcher.
class btISTInstallation : public btISTRegistryListener
{
public:
	btISTInstallation(btCollisionDispatcher* d, std::shared_ptr<btISTContext> c) : dispatcher(d), context(std::move(c)) { install(); }
	~btISTInstallation() override { uninstall(); }

	void install()
	{
		if (!dispatcher) return;
		forEachEntry(
			[this](bool closest, int i, int j)
			{
				btCollisionAlgorithmCreateFunc*& entry = DispatchTables::entry(*dispatcher, closest, i, j);
				CreateFunc& ours = context->function(closest);
				if (entry == &ours) return;
				ours.previous[i][j] = entry;
				entry = &ours;
			});
	}

	bool isComplete() const
	{
		bool complete = dispatcher != nullptr;
		if (complete)
			forEachEntry(
				[&](bool closest, int i, int j)
				{ complete = complete && DispatchTables::entry(*dispatcher, closest, i, j) == &context->function(closest); });
		return complete;
	}

	void uninstall()
	{
		if (!dispatcher) return;
		bool foreign = false;
		forEachEntry(
			[&](bool closest, int i, int j)
			{
				btCollisionAlgorithmCreateFunc*& entry = DispatchTables::entry(*dispatcher, closest, i, j);
				CreateFunc& ours = context->function(closest);
				if (entry == &ours)
					entry = ours.previous[i][j];
				else
					foreign = true;
			});
		context->active = false;
		// Whoever registered after us may hold our functions as his predecessors and call them for as long as he likes; nobody tells
		// us when he stops. They go on delegating, at the price of one context for each such registration.
		if (foreign) new std::shared_ptr<btISTContext>(context);
		dispatcher = nullptr;
	}

	void treeChanged(const btCollisionShape* shape) override
	{
		if (pairCache && dispatcher) clean(pairCache, shape);
	}

	/// All pairs when `shape` is null.
	void clean(btOverlappingPairCache* cache, const btCollisionShape* shape)
	{
		btBroadphasePairArray& pairs = cache->getOverlappingPairArray();
		for (int i = 0; i < pairs.size(); ++i)
		{
			const auto involves = [&](const btBroadphaseProxy* proxy)
			{ return containsShape(static_cast<const btCollisionObject*>(proxy->m_clientObject)->getCollisionShape(), shape); };
			if (!shape || involves(pairs[i].m_pProxy0) || involves(pairs[i].m_pProxy1)) cache->cleanOverlappingPair(pairs[i], dispatcher);
		}
	}

	btCollisionDispatcher* dispatcher;
	btOverlappingPairCache* pairCache = nullptr;
	std::shared_ptr<btISTContext> context;
};

btISTRegistration::~btISTRegistration() = default;
btISTRegistration::btISTRegistration(btISTRegistration&&) noexcept = default;
btISTRegistration& btISTRegistration::operator=(btISTRegistration&&) noexcept = default;
bool btISTRegistration::isRegistered() const { return m_installation && m_installation->isComplete(); }
void btISTRegistration::reinstall() { m_installation->install(); }
void btISTRegistration::release() { m_installation.reset(); }

void btISTRegistration::dispatcherIsGone()
{
	if (!m_installation) return;
	m_installation->dispatcher = nullptr;
	m_installation->pairCache = nullptr;
}

btISTRegistry& btISTRegistration::registry() { return *m_installation->context->registry; }
btISTContactStore& btISTRegistration::store() { return m_installation->context->store; }

void btISTRegistration::setStiffnessRule(std::shared_ptr<const btISTStiffnessRule> rule)
{
	if (rule) m_installation->context->rule = std::move(rule);
}

void btISTRegistration::setPairCache(btOverlappingPairCache* pairCache) { m_installation->pairCache = pairCache; }

void btISTRegistration::cleanPairs(btOverlappingPairCache* pairCache)
{
	if (m_installation && m_installation->dispatcher && pairCache) m_installation->clean(pairCache, nullptr);
}

btISTRegistration btISTCollisionAlgorithm::registerAlgorithm(btCollisionDispatcher* dispatcher, btOverlappingPairCache* pairCache,
															 std::shared_ptr<btISTRegistry> registry)
{
	btISTRegistration registration;
	auto* first = dynamic_cast<CreateFunc*>(DispatchTables::entry(*dispatcher, false, BOX_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE));
	if (first) registration.m_installation = first->context->installation.lock();
	if (!registration.m_installation)
	{
		auto context = std::make_shared<btISTContext>();
		context->registry = registry ? std::move(registry) : std::make_shared<btISTRegistry>();
		registration.m_installation = std::make_shared<btISTInstallation>(dispatcher, context);
		context->installation = registration.m_installation;
		context->registry->addListener(registration.m_installation);
	}
	if (pairCache) registration.setPairCache(pairCache);
	return registration;
}

btISTCollisionAlgorithm::btISTCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info, std::shared_ptr<btISTContext> context,
												 Mode mode, std::shared_ptr<const ist::InnerSphereTree> treeA,
												 std::shared_ptr<const ist::InnerSphereTree> treeB, const btCollisionObject* a,
												 const btCollisionObject* b)
	: btCollisionAlgorithm(info), m_context(std::move(context)), m_treeA(std::move(treeA)), m_treeB(std::move(treeB)),
	  // Never the manifold in `info`: nested compounds would have several pairs write into it. Kept while separated, too: an empty
	  // manifold is what makes Bullet wake a sleeping body when a kinematic one comes near.
	  m_manifold(m_dispatcher->getNewManifold(a, b)),
	  m_contact(mode == Respond ? m_context->store.acquire(m_manifold) : nullptr)
{
}

btISTCollisionAlgorithm::~btISTCollisionAlgorithm()
{
	if (m_contact) m_context->store.release(m_manifold);
	m_dispatcher->releaseManifold(m_manifold);
}

void btISTCollisionAlgorithm::evaluate(const btCollisionObjectWrapper* wrapA, const btCollisionObjectWrapper* wrapB,
									   btISTContact& contact) const
{
	contact.bodyA = wrapA->getCollisionObject();
	contact.bodyB = wrapB->getCollisionObject();
	contact.treeA = m_treeA;
	contact.treeB = m_treeB;
	contact.halfSpace = !m_treeB;
	contact.stamp = m_context->store.step();
	contact.X_WA = toPose(wrapA->getWorldTransform());
	const ist::Pose X_WB = toPose(wrapB->getWorldTransform());
	const ist::Pose X_AB = ist::inverse(contact.X_WA) * X_WB;

	ist::OverlapResult result;
	if (contact.halfSpace)
	{
		const auto* plane = static_cast<const btStaticPlaneShape*>(wrapB->getCollisionShape());
		const ist::Vec3 normal = ist::normalized(X_AB.rotation * toVec3(plane->getPlaneNormal()));
		const double offset = double(plane->getPlaneConstant()) + ist::dot(normal, X_AB.translation);
		result = ist::queryHalfSpace(*m_treeA, normal, offset, m_context->workspace);
	}
	else
		result = ist::queryOverlap(*m_treeA, *m_treeB, X_AB, m_context->workspace);

	contact.status = result.status;
	const bool good = result.status == ist::QueryStatus::Ok;
	contact.total = good ? result.total : ist::OverlapIntegrals();
	contact.patchCount = good ? std::min(result.patchCount, btISTContact::kMaxPatches) : 0;
	std::copy(result.patches, result.patches + contact.patchCount, contact.patches);
	std::fill(contact.impulses, contact.impulses + btISTContact::kMaxPatches, ist::Wrench());
	contact.stiffness = m_context->rule->decide(contact, contact.bodyA, contact.bodyB);
	contact.error = ist::OverlapError();
	const double gap = m_treeA->meanGap + (m_treeB ? m_treeB->meanGap : 0);
	if (contact.total.volume > 0) contact.error = ist::overlapError(contact.total, gap, contact.stiffness.k);
}

void btISTCollisionAlgorithm::processCollision(const btCollisionObjectWrapper* body0Wrap, const btCollisionObjectWrapper* body1Wrap,
											   const btDispatcherInfo&, btManifoldResult* resultOut)
{
	resultOut->setPersistentManifold(m_manifold);
	const bool swapped = body0Wrap->getCollisionObject() != m_manifold->getBody0();
	const btCollisionObjectWrapper* wrapA = swapped ? body1Wrap : body0Wrap;
	const btCollisionObjectWrapper* wrapB = swapped ? body0Wrap : body1Wrap;
	if (m_contact)
	{
		evaluate(wrapA, wrapB, *m_contact);
		writeManifold(*m_manifold, representativePoints(*m_contact), wrapA, wrapB);
		return;
	}
	btISTContact contact;
	evaluate(wrapA, wrapB, contact);
	reportPoints(representativePoints(contact), *resultOut);
}

btScalar btISTCollisionAlgorithm::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&, btManifoldResult*)
{
	return btScalar(1);  // Bullet sweeps convex shapes itself; this is asked for only in DISPATCH_CONTINUOUS
}

void btISTCollisionAlgorithm::getAllContactManifolds(btManifoldArray& manifoldArray)
{
	if (m_contact) manifoldArray.push_back(m_manifold);
}
