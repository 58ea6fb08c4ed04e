// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/VerletList.h"

#include <atomic>
#include <memory>
#include <vector>

struct btISTContact;

/// Of one pair of bodies, for as long as its contact holds it. A thread that was late may still be asking with it while the owner asks
/// again: one of them has it, the other does without. Not installed.
class btISTVerletList
{
public:
	explicit btISTVerletList(int leafPairs) : m_pairs(leafPairs) {}

	/// Mine until it goes; null where another has it, or where there is none.
	class Loan
	{
	public:
		explicit Loan(btISTVerletList* memory)
			: m_memory(memory && !memory->m_lent.exchange(true, std::memory_order_acquire) ? memory : nullptr)
		{}
		~Loan()
		{
			if (m_memory) m_memory->m_lent.store(false, std::memory_order_release);
		}
		Loan(const Loan&) = delete;
		Loan& operator=(const Loan&) = delete;
		ist::VerletList* get() const { return m_memory ? &m_memory->m_pairs : nullptr; }

	private:
		btISTVerletList* m_memory;
	};

private:
	ist::VerletList m_pairs;
	std::atomic<bool> m_lent{false};
};

/// A fixed number of memories for the pairs of a world, first come, first served: a pair of two trees has one from the step after
/// they met in many pairs until they part. Not installed.
class btISTVerletLists
{
public:
	btISTVerletLists(int count, int leafPairs);
	/// For the step after this one, once the pair was asked. The owner's thread alone; no allocation.
	void assign(btISTContact& contact) const;
	int count() const { return int(m_all.size()); }

private:
	std::vector<std::shared_ptr<btISTVerletList>> m_all;
};
