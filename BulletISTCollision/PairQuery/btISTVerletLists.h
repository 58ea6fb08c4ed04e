// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/VerletList.h"

#include <atomic>
#include <memory>
#include <vector>

struct btISTContact;

/// Verlet list of one pair of bodies, for as long as its contact holds it. A late thread may still query with it while the owner repeats
/// the query. Then one of them has the list, and the other works without. Not installed.
class btISTVerletList
{
public:
	explicit btISTVerletList(int leafPairs) : m_pairs(leafPairs) {}

	/// Exclusive use of a list until destruction; null if another thread uses it or if there is none.
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

/// A fixed number of Verlet lists for the pairs of a world, first come, first served. A pair of two trees has a list from the step after
/// they met in many leaf pairs until they part. Not installed.
class btISTVerletLists
{
public:
	btISTVerletLists(int count, int leafPairs);
	/// Assigns or releases the contact's list for the next step; call it after the query. Owner's thread only; no allocation.
	void assign(btISTContact& contact) const;
	int count() const { return int(m_all.size()); }

private:
	std::vector<std::shared_ptr<btISTVerletList>> m_all;
};
