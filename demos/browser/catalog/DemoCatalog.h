// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"

#include <memory>
#include <string>
#include <vector>

namespace browser
{
struct DemoEntry
{
	const char* name;
	const char* group;
	const char* about;  ///< one sentence
	std::unique_ptr<BrowsableDemo> (*make)();
};

/// All demos, in the order of the tree, with groups together.
const std::vector<DemoEntry>& demoCatalog();
/// The demo with this name, or null.
const DemoEntry* findDemo(const std::string& name);
/// Demos whose name, group or description contains every word of `text`, in upper or lower case.
std::vector<const DemoEntry*> searchDemos(const std::string& text);
}  // namespace browser
