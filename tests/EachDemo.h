// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/WorldDemo.h"
#include "demos/browser/catalog/DemoCatalog.h"

#include <gtest/gtest.h>

#include <memory>
#include <ostream>
#include <string>
#include <vector>

// For tests that run once for each demo: which ones, and how the tests are called.
namespace browser
{
inline void PrintTo(const DemoEntry& entry, std::ostream* out) { *out << entry.name; }

/// "heavy-on-light" becomes "heavyonlight": names of tests know no hyphens.
inline std::string testNameOf(const testing::TestParamInfo<DemoEntry>& info)
{
	std::string name = info.param.name;
	std::erase(name, '-');
	return name;
}

/// Those of bodies in a world.
inline std::vector<DemoEntry> demosWithWorlds()
{
	std::vector<DemoEntry> all;
	for (const DemoEntry& entry : demoCatalog())
		if (const auto demo = entry.make(); dynamic_cast<WorldDemo*>(demo.get())) all.push_back(entry);
	return all;
}
}  // namespace browser
