// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Dispatch/btISTQueryThreads.h"

#include "BulletISTCollision/Core/Base/SamePose.h"
#include "BulletISTCollision/Core/Base/SpinPause.h"
#include "BulletISTCollision/Core/Base/SteadyTime.h"
#include "BulletISTCollision/Core/Base/ThreadTime.h"
#include "BulletISTCollision/Core/Platform/ValueWait.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/BroadphaseCollision/btDispatcher.h"
#include "BulletCollision/CollisionDispatch/btCollisionObject.h"

#include <algorithm>

namespace
{
/// Thresholds in pairs of leaves of the last step. kWorthCopying: from this size on (some microseconds of query), a query is worth a copy
/// of its contact. kWorthSharing: from this sum on (some tens of microseconds), all queries except the largest are worth a second thread.
constexpr int64_t kWorthCopying = 64, kWorthSharing = 512;
/// Shortest time for which the owner waits for a query that another thread has begun [us].
constexpr double kShortestWait = 20;
}  // namespace

btISTQueryThreads::btISTQueryThreads(int threads, const ist::QueryCapacity& capacity, double spinMicroseconds)
	: m_ends(size_t(threads)),
	  m_spin(spinMicroseconds)
{
	for (int i = 1; i < threads; ++i) m_helpers.push_back(std::make_unique<Helper>(capacity));
	for (const auto& helper : m_helpers) helper->thread = std::thread([this, &h = *helper] { loop(h); });
}

btISTQueryThreads::~btISTQueryThreads()
{
	m_stop = true;
	++m_turn;
	ist::wakeAll(m_turn);
	for (const auto& helper : m_helpers) helper->thread.join();
}

/// True if no helper is working. Only then may the data that helpers read be written.
bool btISTQueryThreads::isFree() const
{
	return std::none_of(
		m_helpers.begin(), m_helpers.end(), [](const auto& helper) { return helper->working.load(std::memory_order_seq_cst); });
}

void btISTQueryThreads::begin(
	btISTContact& contact, const btISTContactStore& store, const btISTQueryRules& rules, ist::QueryWorkspace& own, btDispatcher& dispatcher)
{
	// A pair that comes a second time belongs to a new pass. This detects passes in worlds without our solver, where steps are not
	// counted. It is not enough alone: a pair that missed one pass would seem to belong to the pass before, for ever.
	if (contact.detectionPass == m_pass || store.step() != m_step) prefetch(store, rules, own, dispatcher);
	contact.detectionPass = m_pass;
}

void btISTQueryThreads::prefetch(
	const btISTContactStore& store, const btISTQueryRules& rules, ist::QueryWorkspace& own, btDispatcher& dispatcher)
{
	m_shared = btISTSharedQueries();
	++m_pass;
	m_step = store.step();
	const bool free = isFree();
	if (free)
	{
		m_rules = rules;
		m_timed = store.measuresQueryTime();
		m_damping = store.sumsDamping();
		gather(store, dispatcher);
	}
	if (free && m_count > 0) answerShared(own);
}

/// Releases trees and Verlet lists: trees are large, lists are few, and an old answer must not keep them.
void btISTQueryThreads::releaseAnswer(Answer& answer)
{
	answer.contact.treeA.reset();
	answer.contact.treeB.reset();
	answer.contact.memory.reset();
}

/// Copies the contacts that touched in the last pass, were queried then, and come again in this pass.
void btISTQueryThreads::gather(const btISTContactStore& store, btDispatcher& dispatcher)
{
	m_count = 0;
	m_wanted.clear();
	// Results that came late were not taken, and still hold trees and lists.
	for (const auto& answer : m_answers) releaseAnswer(*answer);
	int64_t sum = 0, largest = 0;
	for (btISTContact* contact : store.contacts())
	{
		const int64_t cost = ist::costInPairs(contact->total);
		if (cost < kWorthCopying || !contact->canPrefetch || contact->detectionPass + 1 != m_pass || contact->use != btISTCachedResult::Ask)
			continue;
		if (!dispatcher.needsCollision(contact->bodyA, contact->bodyB)) continue;
		m_wanted.emplace_back(cost, contact);
		sum += cost;
		largest = std::max(largest, cost);
	}
	if (sum - largest < kWorthSharing) return;
	std::sort(m_wanted.begin(), m_wanted.end(), [](const auto& p, const auto& q) { return p.first > q.first; });
	while (m_answers.size() < m_wanted.size()) m_answers.push_back(std::make_unique<Answer>());
	for (const auto& [cost, contact] : m_wanted)
	{
		Answer& answer = *m_answers[size_t(m_count)];
		answer.of = contact;
		answer.contact = *contact;
		answer.contact.X_WA = toRigidPose(contact->bodyA->getWorldTransform());
		answer.contact.X_AB = ist::inverse(answer.contact.X_WA) * toRigidPose(contact->bodyB->getWorldTransform());
		contact->prefetchSlot = m_count++;
		answer.detectionPass = m_pass;
		answer.field = contact->treeB ? btISTShapeField() : btISTShapeField(contact->bodyB->getCollisionShape());
		answer.byOwner = false;
		answer.microseconds = 0;
		answer.state.store(Open, std::memory_order_relaxed);
	}
}

void btISTQueryThreads::answer(Answer& answer, ist::QueryWorkspace& workspace) const
{
	const double begin = m_timed ? ist::threadMicroseconds() : 0;
	answer.work = btISTPairQuery(answer.field, m_rules, true, m_damping).answer(answer.contact, workspace, m_timed);
	if (m_timed) answer.microseconds = ist::threadMicroseconds() - begin;
}

void btISTQueryThreads::answerShared(ist::QueryWorkspace& own)
{
	const double begin = m_timed ? ist::threadMicroseconds() : 0;
	m_next.store(0, std::memory_order_relaxed);
	m_open.store(true, std::memory_order_seq_cst);
	m_turn.fetch_add(1, std::memory_order_seq_cst);
	ist::wakeAll(m_turn);
	double longest = kShortestWait;
	for (int i; (i = m_next.fetch_add(1, std::memory_order_relaxed)) < m_count;)
	{
		const double start = ist::steadyMicroseconds();
		Answer& mine = *m_answers[size_t(i)];
		mine.byOwner = true;
		answer(mine, own);
		mine.state.store(Answered, std::memory_order_relaxed);
		longest = std::max(longest, ist::steadyMicroseconds() - start);
	}
	for (int i = 0; i < m_count; ++i)
		if (!m_answers[size_t(i)]->byOwner) waitFor(*m_answers[size_t(i)], longest);
	m_open.store(false, std::memory_order_seq_cst);
	m_shared.pairs = m_count;
	if (m_timed) measure(ist::threadMicroseconds() - begin);
}

void btISTQueryThreads::waitFor(Answer& answer, double microseconds)
{
	++m_shared.byOthers;
	const double start = ist::steadyMicroseconds();
	while (answer.state.load(std::memory_order_acquire) != Answered)
	{
		ist::spinPause();
		if (ist::steadyMicroseconds() - start < microseconds) continue;
		int open = Open;
		m_shared.late += answer.state.compare_exchange_strong(open, Closed, std::memory_order_acq_rel);
		return;
	}
}

void btISTQueryThreads::measure(double ownMicroseconds)
{
	m_shared.ownMicroseconds = ownMicroseconds;
	std::fill(m_ends.begin(), m_ends.end(), 0.0);
	for (int i = 0; i < m_count; ++i)
	{
		const Answer& answer = *m_answers[size_t(i)];
		// The processor time of a late query is not known yet.
		if (answer.state.load(std::memory_order_acquire) != Answered) continue;
		*std::min_element(m_ends.begin(), m_ends.end()) += answer.microseconds;
		m_shared.sumMicroseconds += answer.microseconds;
	}
	m_shared.pathMicroseconds = *std::max_element(m_ends.begin(), m_ends.end());
}

/// Returns the answer to a contact once, and closes it. Null: there is none, or it is late.
btISTQueryThreads::Answer* btISTQueryThreads::answerTo(btISTContact& contact)
{
	const int place = contact.prefetchSlot;
	contact.prefetchSlot = -1;
	if (place < 0 || place >= m_count) return nullptr;
	Answer& answer = *m_answers[size_t(place)];
	if (answer.of != &contact || answer.detectionPass != m_pass || answer.state.load(std::memory_order_acquire) != Answered) return nullptr;
	answer.state.store(Closed, std::memory_order_relaxed);
	return &answer;
}

bool btISTQueryThreads::takeResult(btISTContact& contact, btISTQueryWork& work)
{
	Answer* answer = answerTo(contact);
	if (!answer) return false;
	const bool holds = ist::isSame(answer->contact.X_AB, contact.X_AB);
	if (holds)
	{
		btISTPairQuery::copyAnswer(answer->contact, contact);
		work = answer->work;
	}
	releaseAnswer(*answer);
	return holds;
}

void btISTQueryThreads::release(btISTContact& contact)
{
	if (Answer* answer = answerTo(contact)) releaseAnswer(*answer);
}

void btISTQueryThreads::help(Helper& helper)
{
	for (int i; (i = m_next.fetch_add(1, std::memory_order_relaxed)) < m_count;)
	{
		Answer& taken = *m_answers[size_t(i)];
		answer(taken, helper.workspace);
		int open = Open;
		if (taken.state.compare_exchange_strong(open, Answered, std::memory_order_acq_rel)) continue;
		releaseAnswer(taken);  // the owner has given it up, and may never meet a pair again
		return;
	}
}

void btISTQueryThreads::loop(Helper& helper)
{
	uint32_t seen = 0;
	for (;;)
	{
		const double start = ist::steadyMicroseconds();
		while (m_turn.load(std::memory_order_seq_cst) == seen && ist::steadyMicroseconds() - start < m_spin) ist::spinPause();
		while (m_turn.load(std::memory_order_seq_cst) == seen) ist::sleepWhile(m_turn, seen);
		seen = m_turn.load(std::memory_order_seq_cst);
		if (m_stop) return;
		// The helper sets `working` before it reads `m_open`; the owner closes `m_open` before it reads `working`. So at least one of the
		// two sees the other's write.
		helper.working.store(true, std::memory_order_seq_cst);
		if (m_open.load(std::memory_order_seq_cst)) help(helper);
		helper.working.store(false, std::memory_order_seq_cst);
	}
}
