// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Dispatch/btISTRegistration.h"
#include "BulletISTCollision/PairQuery/btISTPairQuery.h"

#include <atomic>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

class btDispatcher;

/// Queries of several pairs in parallel. At the first pair of a collision detection pass, the pairs that surely follow and are worth the
/// cost are queried ahead, each on a copy of its contact. Bullet then goes on in its usual order on its own thread. A pair takes its
/// prefetched result if that was computed for exactly its present pose; otherwise it is queried as usual. So the result does not depend
/// on the number of threads, with one exception: a pair with a Verlet list (btISTVerletLists) whose thread was late. The owner's thread
/// depends on no other thread: it repeats a query whose result is not there in time. Not installed.
class btISTQueryThreads
{
public:
	btISTQueryThreads(int threads, const ist::QueryCapacity& capacity, double spinMicroseconds);
	~btISTQueryThreads();

	/// Call this when a pair's turn begins. It allocates only when there are more pairs than ever before.
	void begin(btISTContact& contact, const btISTContactStore& store, const btISTQueryRules& rules, ist::QueryWorkspace& own,
		btDispatcher& dispatcher);
	/// Takes the prefetched result for `contact` at its X_AB; false if there is none.
	bool takeResult(btISTContact& contact, btISTQueryWork& work);
	/// Drops the prefetched result of `contact`, which is not needed any more.
	void release(btISTContact& contact);

	int count() const { return int(m_helpers.size()) + 1; }
	/// Shared queries of the last step, or of the step in progress. `step` is the step of the store.
	btISTSharedQueries shared(uint64_t step) const { return m_step + 1 >= step ? m_shared : btISTSharedQueries(); }

private:
	enum State
	{
		Open,  ///< free, or being computed
		Answered,
		Closed  ///< taken, or abandoned
	};
	struct Answer
	{
		btISTContact contact;  ///< a copy
		btISTShapeField field;
		btISTQueryWork work;
		const btISTContact* of = nullptr;
		uint64_t detectionPass = 0;
		double microseconds = 0;
		bool byOwner = false;
		std::atomic<int> state{Closed};
	};
	struct Helper
	{
		explicit Helper(const ist::QueryCapacity& capacity) : workspace(capacity) {}
		ist::QueryWorkspace workspace;
		std::atomic<bool> working{false};
		std::thread thread;
	};

	bool isFree() const;
	void prefetch(const btISTContactStore& store, const btISTQueryRules& rules, ist::QueryWorkspace& own, btDispatcher& dispatcher);
	static void releaseAnswer(Answer& answer);
	Answer* answerTo(btISTContact& contact);
	void gather(const btISTContactStore& store, btDispatcher& dispatcher);
	void answerShared(ist::QueryWorkspace& own);
	void answer(Answer& answer, ist::QueryWorkspace& workspace) const;
	void waitFor(Answer& answer, double microseconds);
	void measure(double ownMicroseconds);
	void loop(Helper& helper);
	void help(Helper& helper);

	std::vector<std::unique_ptr<Answer>> m_answers;  ///< the first m_count belong to this pass, the largest query first
	std::vector<std::pair<int64_t, btISTContact*>> m_wanted;
	int m_count = 0;
	uint64_t m_pass = 1, m_step = 0;  ///< m_step: step of the store in which the pass began
	btISTQueryRules m_rules;          ///< rules of this pass
	bool m_timed = false, m_damping = false;
	btISTSharedQueries m_shared;
	std::vector<double> m_ends;  ///< times at which the threads would end if they were never interrupted [us]
	double m_spin;               ///< time for which a thread spins before it sleeps [us]
	std::atomic<int> m_next{0};
	std::atomic<bool> m_open{false}, m_stop{false};
	std::atomic<uint32_t> m_turn{0};
	std::vector<std::unique_ptr<Helper>> m_helpers;  ///< declared last: everything above exists when their threads begin
};
