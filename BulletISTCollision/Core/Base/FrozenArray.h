// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace ist
{
/// Constant elements that all copies of the array share. They lie in memory of their own, or in a part of an object that the array keeps
/// alive, such as a mapped file. Copying costs O(1).
template <class T> class FrozenArray
{
public:
	FrozenArray() = default;
	FrozenArray(std::vector<T> elements)
	{
		const auto owned = std::make_shared<const std::vector<T>>(std::move(elements));
		m_data = owned->data();
		m_size = owned->size();
		m_owner = owned;
	}
	FrozenArray(std::shared_ptr<const void> owner, const T* data, size_t size) : m_owner(std::move(owner)), m_data(data), m_size(size) {}

	const T& operator[](size_t i) const { return m_data[i]; }
	const T& front() const { return m_data[0]; }
	const T& back() const { return m_data[m_size - 1]; }
	const T* begin() const { return m_data; }
	const T* end() const { return m_data + m_size; }
	const T* data() const { return m_data; }
	size_t size() const { return m_size; }
	bool empty() const { return m_size == 0; }

private:
	std::shared_ptr<const void> m_owner;
	const T* m_data = nullptr;
	size_t m_size = 0;
};
}  // namespace ist
