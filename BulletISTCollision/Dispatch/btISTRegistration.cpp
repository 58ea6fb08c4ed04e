// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTRegistration.h"

#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"
#include "BulletISTCollision/Dispatch/btISTDispatcherClass.h"
#include "BulletISTCollision/Dispatch/btISTInstallation.h"

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"

#include <utility>

namespace
{
/// The reason why a new installation leaves the tables of a dispatcher alone; empty if it does not.
std::string refusalFor(const btCollisionDispatcher* dispatcher, bool hasAnotherRegistry)
{
	if (!dispatcher) return "there is no dispatcher to register with: contact stays Bullet's";
	if (hasAnotherRegistry)
		return "the dispatcher has a registration with another registry, which stays: shapes that are attached to yours are not volumetric "
			   "there; attach them to the registry of the first registration, or pass that one";
	// Any dispatcher of this class is refused, because its scheduler may get threads at any later time.
	if (btISTIsThreaded(*dispatcher))
		return "the dispatcher may call algorithms from several threads at once, which ours does not allow: contact stays Bullet's; "
			   "give the world a btCollisionDispatcher, and query by several threads (setQueryThreads)";
	return {};
}

/// A function in place of a constant, so that objects with static lifetime may call it.
const std::string& released()
{
	static const std::string sentence =
		"this registration was released, moved from or never made: it belongs to no dispatcher; use the one that registerAlgorithm returns";
	return sentence;
}

const btISTContactCache kDefaultContactCache;
}  // namespace

/// Objects that a handle without a registration returns. They belong to that handle alone and have no effect.
struct btISTRegistration::Unregistered
{
	btISTContactStore store;
	btISTRegistry registry;
	btISTPairFilter pairFilter;
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

btISTPairFilter& btISTRegistration::pairFilter()
{
	return m_installation ? m_installation->context->pairFilter : unregistered().pairFilter;
}

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

std::optional<ist::Error> btISTRegistration::requireInnerOverlap(bool on)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	btISTQueryRules& rules = m_installation->context->rules;
	ist::QueryOptions options = rules.options();
	options.requireInnerOverlap = on;
	rules.set(options, rules.forceError());
	return std::nullopt;
}

std::optional<ist::Error> btISTRegistration::setContactCache(const btISTContactCache& contactCache)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	if (!(contactCache.maxError >= 0 && contactCache.maxError <= 0.5))
		return ist::Error{"btISTContactCache::maxError must be a share of the force between 0 and 0.5"};
	m_installation->context->rules.contactCache = contactCache;
	return std::nullopt;
}

const btISTContactCache& btISTRegistration::contactCache() const
{
	return m_installation ? m_installation->context->rules.contactCache : kDefaultContactCache;
}

std::optional<ist::Error> btISTRegistration::setForceError(double share)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	if (!(share >= 0 && share <= 1)) return ist::Error{"a force error must lie between 0 and 1; with 0 the leaves always answer"};
	btISTContext& context = *m_installation->context;
	if (share > 0) context.registry->keepLevels();
	context.rules.set(context.rules.options(), share);
	return std::nullopt;
}

std::optional<ist::Error> btISTRegistration::setForceErrorOf(const btCollisionObject* body, std::optional<double> share)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	if (share && !(*share >= 0 && *share <= 1))
		return ist::Error{"a force error must lie between 0 and 1; with 0 the leaves always answer"};
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
	if (leafPairs < 1 && leafPairs != -1) return ist::Error{"a pair budget must be at least 1 pair of leaves, or -1 for no limit"};
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
	if (!(spinMicroseconds >= 0)) return ist::Error{"query threads must spin for 0 microseconds or more"};
	btISTContext& context = *m_installation->context;
	context.threads.reset();
	if (threads > 1) context.threads = std::make_unique<btISTQueryThreads>(threads, context.workspace.capacity(), spinMicroseconds);
	return std::nullopt;
}

std::optional<ist::Error> btISTRegistration::setVerletLists(int pairsOfBodies, int leafPairs)
{
	if (!refusal().empty()) return ist::Error{refusal()};
	constexpr int kMostMemories = 1024, kMostLeafPairs = 10000000;
	constexpr int64_t kMostTogether = 200000000;  // about 3 GB
	if (pairsOfBodies < 0 || pairsOfBodies > kMostMemories) return ist::Error{"0 to 1024 pairs of bodies can have a Verlet list"};
	if (leafPairs < 1 || leafPairs > kMostLeafPairs) return ist::Error{"a Verlet list can hold 1 to 10000000 pairs of leaves"};
	if (int64_t(pairsOfBodies) * leafPairs > kMostTogether)
		return ist::Error{"all Verlet lists together can hold 200000000 pairs of leaves"};
	std::unique_ptr<btISTVerletLists> memories;
	try
	{
		if (pairsOfBodies > 0) memories = std::make_unique<btISTVerletLists>(pairsOfBodies, leafPairs);
	}
	catch (const std::bad_alloc&)
	{
		return ist::Error{"there is not enough memory for these Verlet lists; ask for fewer lists, or for fewer pairs of leaves"};
	}
	btISTContext& context = *m_installation->context;
	for (btISTContact* contact : context.store.contacts()) contact->memory.reset();
	context.memories = std::move(memories);
	return std::nullopt;
}

int btISTRegistration::verletLists() const
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
	if (dispatcher) registration.m_installation = btISTInstallation::in(*dispatcher);
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
