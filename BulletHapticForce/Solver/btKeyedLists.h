// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <vector>

/// The patches of each key, such as a body, in the order of the patches. It is a counting sort. A patch may have several keys or none.
/// Allocates nothing within the reserved size.
class btPatchIndex
{
public:
	void reserve(size_t keys, size_t entries)
	{
		m_start.reserve(keys + 1);
		m_patches.reserve(entries);
	}
	/// `keysOf(patch, note)` calls `note` with each key of a patch.
	template <class Keys> void fill(int keys, int patchCount, const Keys& keysOf)
	{
		m_start.assign(size_t(keys) + 1, 0);
		for (int k = 0; k < patchCount; ++k) keysOf(k, [this](int key) { ++m_start[size_t(key) + 1]; });
		for (int key = 0; key < keys; ++key) m_start[size_t(key) + 1] += m_start[size_t(key)];
		m_patches.resize(size_t(m_start[size_t(keys)]));
		// Each start is used as the end of the entries so far, and is then moved back by one key.
		for (int k = 0; k < patchCount; ++k) keysOf(k, [this, k](int key) { m_patches[size_t(m_start[size_t(key)]++)] = k; });
		for (int key = keys; key > 0; --key) m_start[size_t(key)] = m_start[size_t(key) - 1];
		m_start[0] = 0;
	}
	const int* begin(int key) const { return m_patches.data() + m_start[size_t(key)]; }
	const int* end(int key) const { return m_patches.data() + m_start[size_t(key) + 1]; }

private:
	std::vector<int> m_start, m_patches;
};
