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
	std::string first = "hello";  ///< name of the first demo
	bool besideStock = false;     ///< true: in two halves, if possible
	std::string show;             ///< drawings to switch on or off (applyChoices)
	long long pictures = -1;      ///< number of pictures after which the window closes itself; negative: it stays open
	int width = 1280, height = 800;
	std::string pictureFolder = ".";  ///< folder for the pictures that F1 takes
	std::string device;               ///< address of a device that moves what the hand holds; empty: only the mouse
	bool forces = false;              ///< whether the hand at the device feels the tool, by a thread of its own
	std::vector<std::pair<int, int>>
		sizes;  ///< size of the window before each of its first pictures, as if the user changed it; {0, 0}: minimised
	std::function<void(bool minimised)> beforePicture;  ///< called before each picture, for tests; may be empty
	std::function<void()> afterPicture;                 ///< called after each drawn picture; may be empty
	std::string screenshot;  ///< file for the last picture with its panels, before the window closes itself; empty: none
};

/// Opens the browser's window, and returns when it is closed. Errors: no display, no OpenGL 3.3.
std::optional<ist::Error> openWindow(const WindowOptions& options);
}  // namespace browser
