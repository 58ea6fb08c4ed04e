// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace browser
{
struct WindowOptions
{
	DemoOptions demo;
	std::string first = "hello";  ///< demo to begin with
	bool besideStock = false;     ///< in two halves, where it can be
	std::string show;             ///< see applyChoices
	long long pictures = -1;      ///< closes itself after so many; negative: stays
	int width = 1280, height = 800;
	std::string pictureFolder = ".";  ///< where F1 leaves its pictures
	std::string device;               ///< address of a device that moves what the hand holds; empty: the mouse alone
	std::vector<std::pair<int, int>>
		sizes;  ///< what becomes of the window before each of its first pictures, as a user may do it; {0, 0}: minimised
	std::function<void(bool minimised)> beforePicture;  ///< for those who watch; may be empty
	std::function<void()> afterPicture;                 ///< once one is drawn; may be empty
	std::string screenshot;                             ///< of the last picture before it closes itself, panels and all; empty: none
};

/// Opens the browser's window and stays until it is closed. Errors: no display, no OpenGL 3.3.
std::optional<ist::Error> openWindow(const WindowOptions& options);
}  // namespace browser
