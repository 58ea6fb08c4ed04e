// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Preload/Backend.h"

#include <atomic>
#include <mutex>

namespace preload
{
/// False when BULLETHAPTICS_PRELOAD is "off".
bool isPreloadOn();

/// The backend of one precision. Its library lies in the folder `preload` beside this library.
class PreloadedBackend
{
public:
	/// `precision`: "single" or "double", a part of the file's name.
	explicit constexpr PreloadedBackend(const char* precision) : m_precision(precision) {}

	/// Returns the backend for the Bullet to which this `stepSimulation` belongs. Null, and reported once, when there is no backend or it
	/// is bound to another Bullet.
	const Backend* forBulletOf(const void* step);
	/// The loaded backend; null until a world is stepped.
	const Backend* loaded() const { return m_backend.load(std::memory_order_acquire); }
	/// True when a world of this precision was stepped.
	bool wasAsked() const { return m_asked.load(std::memory_order_relaxed); }

private:
	static constexpr int kKnown = 8;
	struct Known
	{
		const void* step;
		bool suits;
	};

	void load();
	bool suits(const void* step) const;

	const char* m_precision;
	std::mutex m_mutex;
	std::atomic<bool> m_asked{false};
	std::atomic<const Backend*> m_backend{nullptr};
	int m_count = 0;
	Known m_known[kKnown] = {};
};
}  // namespace preload
