// SPDX-License-Identifier: Zlib
// A program without Bullet that plays a game from a plug-in, as simulators do: plugin_host FILE [ARGUMENTS]. Only the plug-in is linked
// with Bullet.
#include <dlfcn.h>

#include <cstdio>

int main(int argc, char** argv)
{
	if (argc < 2) return 2;
	void* const plugin = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
	auto* const play = plugin ? reinterpret_cast<int (*)(int, char**)>(dlsym(plugin, "play")) : nullptr;
	if (!play)
	{
		std::fprintf(stderr, "%s\n", dlerror());
		return 2;
	}
	const int result = play(argc - 1, argv + 1);
	return dlclose(plugin) == 0 ? result : 2;
}
