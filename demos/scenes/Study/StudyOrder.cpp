// SPDX-License-Identifier: Zlib
#include "demos/scenes/Study/StudyOrder.h"

#include <algorithm>
#include <numeric>
#include <random>

namespace scenes
{
int williamsRows(int conditions) { return conditions % 2 == 0 || conditions == 1 ? conditions : 2 * conditions; }

std::vector<int> studyOrder(int conditions, int participant, int block, std::uint64_t seed)
{
	const int n = conditions, row = (participant % williamsRows(n) + block % williamsRows(n)) % williamsRows(n);
	std::vector<int> order;
	// The first row is 0, 1, n-1, 2, n-2, ...; each next row adds 1. The second half of an odd square has the rows reversed.
	for (int i = 0; i < n; ++i) order.push_back(((i % 2 == 1 ? (i + 1) / 2 : n - i / 2) + row) % n);
	if (row >= n) std::reverse(order.begin(), order.end());
	std::vector<int> condition(static_cast<std::size_t>(n));
	std::iota(condition.begin(), condition.end(), 0);
	std::mt19937_64 random(seed);
	// std::shuffle may differ between libraries.
	for (int i = n - 1; i > 0; --i) std::swap(condition[std::size_t(i)], condition[std::size_t(random() % std::uint64_t(i + 1))]);
	for (int& number : order) number = condition[std::size_t(number)];
	return order;
}
}  // namespace scenes
