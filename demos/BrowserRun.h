// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/DemoArguments.h"

namespace scenes
{
/// True when the browser has a demo of that name.
bool isBrowserDemo(const std::string& name);
/// Names and descriptions, one a line.
void listBrowserDemos();
/// The demo without a window: figures, and the pictures that were asked for. Returns the exit code.
int runBrowserDemo(const DemoArguments& a);
/// The window, on the demo that was named or the first. Returns the exit code.
int openBrowser(const DemoArguments& a);
/// A picture of every demo, and a page that shows them. Returns the exit code.
int makeGallery(const DemoArguments& a);
}  // namespace scenes
