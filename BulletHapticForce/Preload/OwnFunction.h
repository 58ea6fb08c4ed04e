// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Preload/LoadedModule.h"

#include <mutex>

namespace preload
{
/// Finds Bullet's own function behind one that this library interposes. A program may contain several copies of Bullet, in both
/// precisions and in plug-ins. The module of an object's virtual table tells to which copy the object belongs.
class OwnFunction
{
public:
	OwnFunction(const char* symbol, const void* interposed) : m_symbol(symbol), m_interposed(interposed) {}

	/// Returns Bullet's function for `object`, which begins with the pointer to its virtual table. Null if no library defines the
	/// function.
	template <class Function> Function* of(const void* object)
	{
		return reinterpret_cast<Function*>(find(*static_cast<const void* const*>(object)));
	}

private:
	static constexpr int kKept = 16;
	struct Kept
	{
		const void* table;
		void* function;
	};

	void* find(const void* table)
	{
		const unsigned long long unloads = unloadCount();
		{
			const std::lock_guard lock(m_mutex);
			if (unloads != m_unloads) m_count = 0;
			m_unloads = unloads;
			for (int i = 0; i < m_count; ++i)
				if (m_kept[i].table == table) return m_kept[i].function;
		}
		// Our lock is not held here. The loader has a lock of its own, and it calls destructors of unloaded libraries, which lead here,
		// while it holds that lock.
		void* const function = definitionFor(table, m_symbol, m_interposed);
		const std::lock_guard lock(m_mutex);
		if (unloads == m_unloads && m_count < kKept) m_kept[m_count++] = {table, function};
		return function;
	}

	const char* m_symbol;
	const void* m_interposed;
	std::mutex m_mutex;
	unsigned long long m_unloads = 0;
	int m_count = 0;
	Kept m_kept[kKept] = {};
};
}  // namespace preload
