// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <vector>

/// A list of numbers for each key, such as the patches of each body. The numbers of a list ascend. It is a counting sort. A number may
/// stand in several lists or in none. Allocates nothing within the reserved size.
class btKeyedLists
{
public:
	void reserve(size_t keys, size_t entries)
	{
		m_start.reserve(keys + 1);
		m_numbers.reserve(entries);
	}
	/// Sorts the numbers from 0 to `count` - 1. `keysOf(number, note)` calls `note` with each key of a number.
	template <class Keys> void fill(int keys, int count, const Keys& keysOf)
	{
		m_start.assign(size_t(keys) + 1, 0);
		for (int k = 0; k < count; ++k) keysOf(k, [this](int key) { ++m_start[size_t(key) + 1]; });
		for (int key = 0; key < keys; ++key) m_start[size_t(key) + 1] += m_start[size_t(key)];
		m_numbers.resize(size_t(m_start[size_t(keys)]));
		// Each start is used as the end of the entries so far, and is then moved back by one key.
		for (int k = 0; k < count; ++k) keysOf(k, [this, k](int key) { m_numbers[size_t(m_start[size_t(key)]++)] = k; });
		for (int key = keys; key > 0; --key) m_start[size_t(key)] = m_start[size_t(key) - 1];
		m_start[0] = 0;
	}
	const int* begin(int key) const { return m_numbers.data() + m_start[size_t(key)]; }
	const int* end(int key) const { return m_numbers.data() + m_start[size_t(key) + 1]; }

private:
	std::vector<int> m_start, m_numbers;
};
