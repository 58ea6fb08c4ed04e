// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"
#include "BulletISTCollision/Dispatch/btISTContext.h"
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

/// Bullet makes an algorithm for each child of a GImpact compound and destroys it within the same call: no contact would see the solver.
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

/// The tables are protected and have no getter; a member pointer named through a derived class may read them on any dispatcher.
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
		auto treeA = context->registry->find(shape0);
		auto treeB = context->registry->find(shape1);
		// A shape whose tree does not speak for it now, as it was scaled, is Bullet's.
		const auto hasForm = [this](const btCollisionShape* shape) {
			return !context->registry->isAttached(shape) && btISTShapeField(shape).field();
		};
		const bool volumetric = (treeA && treeB) || (treeA && hasForm(shape1)) || (treeB && hasForm(shape0));
		if (volumetric && !isInGImpactCompound(wrap0) && !isInGImpactCompound(wrap1))
		{
			const bool swapped = !treeA;  // A has the tree
			if (swapped) std::swap(treeA, treeB);
			const auto mode = closest ? btISTCollisionAlgorithm::Query : btISTCollisionAlgorithm::Respond;
			void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(int(sizeof(btISTCollisionAlgorithm)));
			return new (memory) btISTCollisionAlgorithm(info, context->shared_from_this(), mode, std::move(treeA), std::move(treeB),
				*(swapped ? wrap1 : wrap0), *(swapped ? wrap0 : wrap1));
		}
		// GImpact takes a compound apart by itself and asks nobody about the children. Bullet's algorithm for compounds does, as with any
		// convex shape.
		if (treeA && type0 == GIMPACT_SHAPE_PROXYTYPE && type1 == COMPOUND_SHAPE_PROXYTYPE) type0 = BOX_SHAPE_PROXYTYPE;
		if (treeB && type1 == GIMPACT_SHAPE_PROXYTYPE && type0 == COMPOUND_SHAPE_PROXYTYPE) type1 = BOX_SHAPE_PROXYTYPE;
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

/// Our entries in one dispatcher.
class btISTInstallation : public btISTRegistryListener
{
public:
	/// With a refusal the tables stay as they are, and the context has no effect.
	btISTInstallation(btCollisionDispatcher* d, std::shared_ptr<btISTContext> c, std::string reason)
		: dispatcher(reason.empty() ? d : nullptr),
		  refusal(std::move(reason)),
		  context(std::move(c))
	{
		install();
	}
	~btISTInstallation() override { uninstall(); }

	void install()
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

	bool isComplete() const
	{
		bool complete = dispatcher != nullptr;
		if (complete)
			forEachEntry([&](bool closest, int i, int j) {
				complete = complete && DispatchTables::entry(*dispatcher, closest, i, j) == &context->function(closest);
			});
		return complete;
	}

	void uninstall()
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
		// Whoever registered after us may hold our functions as his predecessors and call them for as long as he likes; nobody tells
		// us when he stops. They go on delegating, at the price of one context for each such registration.
		if (foreign) new std::shared_ptr<btISTContext>(context);
		dispatcher = nullptr;
	}

	void treeChanged(const btCollisionShape* shape) override
	{
		if (!pairCache || !dispatcher) return;
		// A shape that loses its tree may be the next to go, and others before it may have gone: they are not asked.
		if (context->registry->isAttached(shape)) clean(pairCache, shape);
		else cleanPairsOf(shape);
	}

	/// Those of bodies with that shape, and of compounds whose children have a contact. Pairs of another cache, as a ghost's, find out by
	/// themselves.
	void cleanPairsOf(const btCollisionShape* shape)
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
			// The last contact has moved into the gap.
			if (contacts.size() < before) i = 0;
			else ++i;
		}
	}

	void cleanPair(const btPersistentManifold& manifold)
	{
		btBroadphaseProxy* const a = const_cast<btBroadphaseProxy*>(manifold.getBody0()->getBroadphaseHandle());
		btBroadphaseProxy* const b = const_cast<btBroadphaseProxy*>(manifold.getBody1()->getBroadphaseHandle());
		btBroadphasePair* pair = a && b ? pairCache->findPair(a, b) : nullptr;
		if (pair) pairCache->cleanOverlappingPair(*pair, dispatcher);
	}

	/// All pairs when `shape` is null.
	void clean(btOverlappingPairCache* cache, const btCollisionShape* shape)
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

	btCollisionDispatcher* dispatcher;  ///< null: there is none any more, or it was refused
	std::string refusal;
	btOverlappingPairCache* pairCache = nullptr;
	std::shared_ptr<btISTContext> context;
};

namespace
{
/// The installation whose functions stand in the tables of a dispatcher; null without one. Others may have overwritten some entries.
std::shared_ptr<btISTInstallation> installationIn(btCollisionDispatcher& dispatcher)
{
	std::shared_ptr<btISTInstallation> found;
	const btCollisionAlgorithmCreateFunc* last = nullptr;
	forEachEntry([&](bool closest, int i, int j) {
		const btCollisionAlgorithmCreateFunc* entry = DispatchTables::entry(dispatcher, closest, i, j);
		if (found || entry == last) return;
		last = entry;
		if (const auto* ours = dynamic_cast<const btISTCreateFunc*>(entry)) found = ours->context->installation.lock();
	});
	return found;
}

/// Why a new installation leaves the tables of a dispatcher alone; empty when it does not.
std::string refusalFor(const btCollisionDispatcher* dispatcher, bool hasAnotherRegistry)
{
	if (!dispatcher) return "there is no dispatcher to register with: contact stays Bullet's";
	if (hasAnotherRegistry)
		return "the dispatcher has a registration with another registry, which stays: shapes that are attached to yours are not volumetric "
			   "there; attach them to the registry of the first registration, or pass that one";
	// Its scheduler may get its threads at any later time.
	if (dynamic_cast<const btCollisionDispatcherMt*>(dispatcher))
		return "the dispatcher may call algorithms from several threads at once, which ours does not allow: contact stays Bullet's; "
			   "give the world a btCollisionDispatcher, and its queries threads of their own";
	return {};
}

/// A function, so that objects with static lifetime may ask.
const std::string& released()
{
	static const std::string sentence =
		"this registration was released, moved from or never made: it belongs to no dispatcher; use the one that registerAlgorithm returns";
	return sentence;
}

const btISTEconomy kDefaultEconomy;
}  // namespace

/// What a handle without a registration shows. It belongs to that handle alone and acts on nothing.
struct btISTRegistration::Unregistered
{
	btISTContactStore store;
	btISTRegistry registry;
	btISTWatch watch;
};

btISTRegistration::Unregistered& btISTRegistration::unregistered() const
{
	if (!m_unregistered) m_unregistered = std::make_shared<Unregistered>();
	return *m_unregistered;
}

btISTRegistration::~btISTRegistration() = default;
btISTRegistration::btISTRegistration(btISTRegistration&&) noexcept = default;
btISTRegistration& btISTRegistration::operator=(btISTRegistration&&) noexcept = default;
bool btISTRegistration::isRegistered() const { return m_installation && m_installation->isComplete(); }

const std::string& btISTRegistration::refusal() const { return m_installation ? m_installation->refusal : released(); }

std::optional<ist::Error> btISTRegistration::reinstall()
{
	if (!refusal().empty()) return ist::Error{refusal()};
	m_installation->install();
	return std::nullopt;
}

std::optional<ist::Error> btISTRegistration::makeResident()
{
	if (!refusal().empty()) return ist::Error{refusal()};
	m_installation->context->workspace.makeResident();
	return std::nullopt;
}

void btISTRegistration::release()
{
	m_installation.reset();
	m_ruleClaim.reset();
}

void btISTRegistration::dispatcherIsGone()
{
	if (!m_installation) return;
	m_installation->dispatcher = nullptr;
	m_installation->pairCache = nullptr;
}

btISTRegistry& btISTRegistration::registry() { return m_installation ? *m_installation->context->registry : unregistered().registry; }
btISTContactStore& btISTRegistration::store() { return m_installation ? m_installation->context->store : unregistered().store; }

std::shared_ptr<btISTContactStore> btISTRegistration::sharedStore() const
{
	if (!m_installation)
	{
		btISTContactStore* const store = &unregistered().store;
		return std::shared_ptr<btISTContactStore>(m_unregistered, store);
	}
	return std::shared_ptr<btISTContactStore>(m_installation->context, &m_installation->context->store);
}

btISTWatch& btISTRegistration::watch() { return m_installation ? m_installation->context->watch : unregistered().watch; }

std::optional<ist::Error> btISTRegistration::setPairRule(std::shared_ptr<const btISTPairRule> rule)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	if (!rule) return ist::Error{"there is no pair rule to set; the one before stays"};
	btISTContext& context = *m_installation->context;
	const std::shared_ptr<const void> claim = context.ruleClaim.lock();
	if (claim && claim != m_ruleClaim)
		return ist::Error{
			"a btISTWorld, or another registration of this dispatcher, has set the pair rule, which stays; set yours through that "
			"one, or release it first"};
	if (!m_ruleClaim) m_ruleClaim = std::make_shared<char>();
	context.ruleClaim = m_ruleClaim;
	context.rule = std::move(rule);
	return std::nullopt;
}

std::optional<ist::Error> btISTRegistration::setGate(bool on)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	btISTQueryRules& rules = m_installation->context->rules;
	ist::QueryOptions options = rules.options();
	options.gate = on;
	rules.set(options, rules.forceError());
	return std::nullopt;
}

std::optional<ist::Error> btISTRegistration::setEconomy(const btISTEconomy& economy)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	if (!(economy.keptError >= 0 && economy.keptError <= 0.5))
		return ist::Error{"the error that kept results may add must be a share of the force between 0 and 0.5"};
	m_installation->context->rules.economy = economy;
	return std::nullopt;
}

const btISTEconomy& btISTRegistration::economy() const { return m_installation ? m_installation->context->rules.economy : kDefaultEconomy; }

std::optional<ist::Error> btISTRegistration::setForceError(double share)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	if (!(share >= 0 && share <= 1)) return ist::Error{"a force error must lie between 0 and 1; 0 asks the leaves always"};
	btISTContext& context = *m_installation->context;
	if (share > 0) context.registry->keepLevels();
	context.rules.set(context.rules.options(), share);
	return std::nullopt;
}

std::optional<ist::Error> btISTRegistration::setForceErrorOf(const btCollisionObject* body, std::optional<double> share)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	if (share && !(*share >= 0 && *share <= 1)) return ist::Error{"a force error must lie between 0 and 1; 0 asks the leaves always"};
	btISTContext& context = *m_installation->context;
	if (share && *share > 0) context.registry->keepLevels();
	context.rules.setForceErrorOf(body, share);
	return std::nullopt;
}

double btISTRegistration::forceErrorOf(const btCollisionObject* a, const btCollisionObject* b) const
{
	return m_installation ? m_installation->context->rules.forceErrorOf(a, b) : 0;
}

std::optional<ist::Error> btISTRegistration::setPairBudget(int64_t leafPairs)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	if (leafPairs < 1 && leafPairs != -1) return ist::Error{"a query must be allowed to find 1 pair of leaves at least; -1: any number"};
	btISTContext& context = *m_installation->context;
	if (leafPairs > 0) context.registry->keepLevels();
	ist::QueryOptions options = context.rules.options();
	options.maxPairs = leafPairs;
	options.blend = leafPairs > 0;
	context.rules.set(options, context.rules.forceError());
	return std::nullopt;
}

int64_t btISTRegistration::pairBudget() const
{
	return m_installation ? m_installation->context->rules.options().maxPairs : ist::QueryOptions().maxPairs;
}

double btISTRegistration::forceError() const { return m_installation ? m_installation->context->rules.forceError() : 0; }

std::optional<ist::Error> btISTRegistration::setQueryThreads(int threads, double spinMicroseconds)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	constexpr int kMostThreads = 64;
	if (threads < 1 || threads > kMostThreads) return ist::Error{"queries can have 1 to 64 threads"};
	if (!(spinMicroseconds >= 0)) return ist::Error{"threads of queries can spin for no less than 0 microseconds"};
	btISTContext& context = *m_installation->context;
	context.threads.reset();
	if (threads > 1) context.threads = std::make_unique<btISTQueryThreads>(threads, context.workspace.capacity(), spinMicroseconds);
	return std::nullopt;
}

std::optional<ist::Error> btISTRegistration::setPairMemory(int pairsOfBodies, int leafPairs)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	constexpr int kMostMemories = 1024, kMostLeafPairs = 10000000;
	constexpr int64_t kMostTogether = 200000000;  // some 3 GB
	if (pairsOfBodies < 0 || pairsOfBodies > kMostMemories) return ist::Error{"0 to 1024 pairs of bodies can have a memory"};
	if (leafPairs < 1 || leafPairs > kMostLeafPairs) return ist::Error{"a memory can have room for 1 to 10000000 pairs of leaves"};
	if (int64_t(pairsOfBodies) * leafPairs > kMostTogether)
		return ist::Error{"all memories together can have room for 200000000 pairs of leaves"};
	std::unique_ptr<btISTPairMemories> memories;
	try
	{
		if (pairsOfBodies > 0) memories = std::make_unique<btISTPairMemories>(pairsOfBodies, leafPairs);
	}
	catch (const std::bad_alloc&)
	{
		return ist::Error{"there is no room for so many memories; fewer, or for fewer pairs of leaves, take less"};
	}
	btISTContext& context = *m_installation->context;
	for (btISTContact* contact : context.store.contacts()) contact->memory.reset();
	context.memories = std::move(memories);
	return std::nullopt;
}

int btISTRegistration::pairMemory() const
{
	if (!m_installation) return 0;
	const auto& memories = m_installation->context->memories;
	return memories ? memories->count() : 0;
}

int btISTRegistration::queryThreads() const
{
	if (!m_installation) return 1;
	const auto& threads = m_installation->context->threads;
	return threads ? threads->count() : 1;
}

btISTSharedQueries btISTRegistration::sharedQueries() const
{
	if (!m_installation) return {};
	const auto& threads = m_installation->context->threads;
	return threads ? threads->shared(m_installation->context->store.step()) : btISTSharedQueries();
}

std::optional<ist::Error> btISTRegistration::setPairCache(btOverlappingPairCache* pairCache)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	m_installation->pairCache = pairCache;
	return std::nullopt;
}

void btISTRegistration::cleanPairs(btOverlappingPairCache* pairCache)
{
	if (m_installation && m_installation->dispatcher && pairCache) m_installation->clean(pairCache, nullptr);
}

btISTRegistration btISTCollisionAlgorithm::registerAlgorithm(
	btCollisionDispatcher* dispatcher, btOverlappingPairCache* pairCache, std::shared_ptr<btISTRegistry> registry)
{
	btISTRegistration registration;
	if (dispatcher) registration.m_installation = installationIn(*dispatcher);
	const bool hasAnotherRegistry = registration.m_installation && registry && registration.m_installation->context->registry != registry;
	if (!registration.m_installation || hasAnotherRegistry)
	{
		auto context = std::make_shared<btISTContext>();
		context->registry = registry ? std::move(registry) : std::make_shared<btISTRegistry>();
		registration.m_installation = std::make_shared<btISTInstallation>(dispatcher, context, refusalFor(dispatcher, hasAnotherRegistry));
		context->installation = registration.m_installation;
		context->registry->addListener(registration.m_installation);
	}
	if (pairCache) (void)registration.setPairCache(pairCache);
	return registration;
}
