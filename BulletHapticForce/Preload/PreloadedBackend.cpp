// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Preload/PreloadedBackend.h"

#include "BulletHapticForce/Preload/LoadedModule.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <limits.h>

namespace preload
{
namespace
{
/// Folder of this library, with a slash at its end. It is read when the library is loaded, because a program may change its working
/// directory later.
struct OwnFolder
{
	char path[PATH_MAX] = "";

	OwnFolder()
	{
		Dl_info self{};
		if (!dladdr(reinterpret_cast<const void*>(&isPreloadOn), &self) || !self.dli_fname || !realpath(self.dli_fname, path)) path[0] = 0;
		if (char* slash = std::strrchr(path, '/')) slash[1] = 0;
	}
};
const OwnFolder folder;
}  // namespace

bool isPreloadOn()
{
	static const bool on = [] {
		const char* text = std::getenv("BULLETHAPTICS_PRELOAD");
		return !text || std::strcmp(text, "off") != 0;
	}();
	return on;
}

void PreloadedBackend::load()
{
	if (!folder.path[0])
	{
		std::fprintf(
			stderr, "bullethaptics-preload: this library cannot find its own file, and so not the one beside it: nothing is changed\n");
		return;
	}
	char path[PATH_MAX + 64];
	std::snprintf(path, sizeof(path), "%spreload/libbullethaptics-%s.so", folder.path, m_precision);
	// RTLD_LOCAL keeps plug-ins that are loaded later from finding this library's Bullet.
	void* const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
	auto* const get = library ? reinterpret_cast<GetBackend*>(dlsym(library, kGetBackend)) : nullptr;
	if (get) m_backend.store(get(), std::memory_order_release);
	else
		std::fprintf(stderr, "bullethaptics-preload: the library for Bullet in %s precision cannot be loaded (%s): nothing is changed\n",
			m_precision, dlerror());
}

bool PreloadedBackend::suits(const void* step) const
{
	const Backend* backend = loaded();
	if (!backend) return false;
	for (const BoundFunction* each = backend->bound; each->symbol; ++each)
		if (definitionFor(step, each->symbol, nullptr) != each->address)
		{
			const char* file = moduleOf(step);
			std::fprintf(stderr,
				"bullethaptics-preload: the program's Bullet (%s) is not the one that this library needs: nothing is changed\n",
				file && *file ? file : "in the program itself");
			return false;
		}
	return true;
}

const Backend* PreloadedBackend::forBulletOf(const void* step)
{
	const std::lock_guard lock(m_mutex);
	if (!m_asked.exchange(true, std::memory_order_relaxed)) load();
	for (int i = 0; i < m_count; ++i)
		if (m_known[i].step == step) return m_known[i].suits ? loaded() : nullptr;
	const bool isOurs = m_count < kKnown && suits(step);
	if (m_count < kKnown) m_known[m_count++] = {step, isOurs};
	return isOurs ? loaded() : nullptr;
}
}  // namespace preload
