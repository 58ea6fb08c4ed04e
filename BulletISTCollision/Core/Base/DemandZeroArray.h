// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

namespace ist
{
/// Maps zeroed memory from the system, in whole pages. A page becomes resident when it is first written. Throws std::bad_alloc.
void* mapZeroPages(size_t bytes);
/// Unmaps the memory that `mapZeroPages` returned for this size.
void unmapPages(void* pages, size_t bytes) noexcept;
/// Makes every page resident, so that no later write waits for the system.
void touchPages(void* pages, size_t bytes) noexcept;

/// An array of zeros whose unused pages cost no memory. A workspace reserves the largest number of pairs that a query may find, but most
/// queries find few. All elements begin as zero bytes; no constructor or destructor runs.
template <class T> class DemandZeroArray
{
	static_assert(std::is_trivially_copyable_v<T>, "elements begin as zero bytes");

public:
	DemandZeroArray() = default;
	explicit DemandZeroArray(size_t size) : m_data(static_cast<T*>(mapZeroPages(size * sizeof(T)))), m_size(size) {}
	~DemandZeroArray() { unmapPages(m_data, m_size * sizeof(T)); }
	DemandZeroArray(DemandZeroArray&& other) noexcept : m_data(std::exchange(other.m_data, nullptr)), m_size(std::exchange(other.m_size, 0))
	{}
	DemandZeroArray& operator=(DemandZeroArray&& other) noexcept
	{
		std::swap(m_data, other.m_data);
		std::swap(m_size, other.m_size);
		return *this;
	}

	T* data() { return m_data; }
	const T* data() const { return m_data; }
	size_t size() const { return m_size; }
	T& operator[](size_t i) { return m_data[i]; }
	const T& operator[](size_t i) const { return m_data[i]; }
	/// Makes the whole array resident.
	void touch() noexcept { touchPages(m_data, m_size * sizeof(T)); }

private:
	T* m_data = nullptr;
	size_t m_size = 0;
};
}  // namespace ist
