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

/// Queries of several pairs side by side. When the first pair of a pass of collision detection is met, those that surely come and are worth
/// it are answered ahead of their turn, each on a copy of its contact. Bullet then goes on as ever, in its order and on its thread; a pair
/// takes its answer where that is for the very pose that it has in its turn, and is asked as ever where it has none. So nobody can tell how
/// many threads there were, but where pairs remember their leaves (btISTVerletLists) and one was late; and the owner depends on none of
/// them: what he does not get in good time he asks for himself. Not installed.
class btISTQueryThreads
{
public:
	btISTQueryThreads(int threads, const ist::QueryCapacity& capacity, double spinMicroseconds);
	~btISTQueryThreads();

	/// A pair's turn begins. No allocation but for more pairs than ever.
	void begin(btISTContact& contact, const btISTContactStore& store, const btISTQueryRules& rules, ist::QueryWorkspace& own,
		btDispatcher& dispatcher);
	/// The answer for `contact` at its X_AB; false where there is none.
	bool takeResult(btISTContact& contact, btISTQueryWork& work);
	/// `contact` wants none any more.
	void release(btISTContact& contact);

	int count() const { return int(m_helpers.size()) + 1; }
	/// What was shared in the last step, or in the one in progress; `step` of the store.
	btISTSharedQueries shared(uint64_t step) const { return m_step + 1 >= step ? m_shared : btISTSharedQueries(); }

private:
	enum State
	{
		Open,  ///< nobody's, or being answered
		Answered,
		Closed  ///< taken, or given up
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

	std::vector<std::unique_ptr<Answer>> m_answers;  ///< the first m_count are of this pass, the longest first
	std::vector<std::pair<int64_t, btISTContact*>> m_wanted;
	int m_count = 0;
	uint64_t m_pass = 1, m_step = 0;  ///< of the store, in which the pass began
	btISTQueryRules m_rules;          ///< of this pass
	bool m_timed = false, m_damping = false;
	btISTSharedQueries m_shared;
	std::vector<double> m_ends;  ///< of the threads, as if they were never interrupted [us]
	double m_spin;               ///< [us]
	std::atomic<int> m_next{0};
	std::atomic<bool> m_open{false}, m_stop{false};
	std::atomic<uint32_t> m_turn{0};
	std::vector<std::unique_ptr<Helper>> m_helpers;  ///< last: all above is there when their threads begin
};
