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

/// All demos, in the order of the tree: groups stand together.
const std::vector<DemoEntry>& demoCatalog();
/// Null when no demo is called so.
const DemoEntry* findDemo(const std::string& name);
/// Those whose name, group or description contains every word of `text`, whatever the case.
std::vector<const DemoEntry*> searchDemos(const std::string& text);
}  // namespace browser
