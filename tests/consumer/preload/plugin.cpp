// SPDX-License-Identifier: Zlib
// The game of stock_game in a plug-in, for plugin_host. With `--left` its world goes when the plug-in is unloaded.
#define main playGame
#include "../stock_game/game.cpp"
#undef main

namespace
{
std::unique_ptr<Game> left;
}  // namespace

extern "C" int play(int argc, char** argv)
{
	if (argc < 2 || std::strcmp(argv[1], "--left") != 0) return playGame(argc, argv);
	left = std::make_unique<Game>();
	for (int i = 0; i < 60; ++i)
	{
		left->frame();
		left->print(i);
	}
	return 0;
}
