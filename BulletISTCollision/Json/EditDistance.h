// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

namespace ist
{
/// Number of letters that must be inserted, removed or replaced to turn one word into the other.
inline size_t editDistance(std::string_view a, std::string_view b)
{
	std::vector<size_t> row(b.size() + 1);
	std::iota(row.begin(), row.end(), size_t(0));
	for (size_t i = 0; i < a.size(); ++i)
	{
		size_t diagonal = std::exchange(row[0], i + 1);
		for (size_t j = 0; j < b.size(); ++j)
		{
			const size_t replaced = diagonal + (a[i] != b[j]);
			diagonal = row[j + 1];
			row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
		}
	}
	return row[b.size()];
}
}  // namespace ist
