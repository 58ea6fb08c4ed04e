// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/PairQuery/btISTVerletLists.h"

#include "BulletISTCollision/Contact/btISTContactStore.h"

#include <algorithm>

namespace
{
/// Number of leaf pairs from which on a list is worth its own cost (some microseconds of traversal).
constexpr int64_t kWorthRemembering = 100;
}  // namespace

btISTVerletLists::btISTVerletLists(int count, int leafPairs)
{
	for (int i = 0; i < count; ++i) m_all.push_back(std::make_shared<btISTVerletList>(leafPairs));
}

void btISTVerletLists::assign(btISTContact& contact) const
{
	if (contact.total.pairs == 0 || !contact.treeB || contact.total.surfaceVolume > 0) return contact.memory.reset();
	if (contact.memory || contact.total.pairs < kWorthRemembering) return;
	// Copies of contacts that other threads answer hold the list, too. A list that only m_all holds is not in use.
	const auto free = std::find_if(m_all.begin(), m_all.end(), [](const auto& memory) { return memory.use_count() == 1; });
	if (free == m_all.end()) return;
	const btISTVerletList::Loan mine(free->get());
	if (!mine.get()) return;
	mine.get()->forget();
	contact.memory = *free;
}
