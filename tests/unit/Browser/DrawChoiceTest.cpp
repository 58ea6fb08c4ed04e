// SPDX-License-Identifier: Zlib
#include "demos/browser/drawing/DrawChoice.h"

#include <gtest/gtest.h>

#include <set>

using namespace browser;

TEST(DrawChoice, NamesSwitchOnAndOffAndUnknownOnesAreNamed)
{
	DrawChoice choice;
	EXPECT_EQ(applyChoices("", choice), "");
	EXPECT_EQ(applyChoices("spheres,no-meshes,levels", choice), "");
	EXPECT_TRUE(choice.spheres && choice.levels && !choice.surfaces && choice.wrenches);
	EXPECT_EQ(applyChoices("lenses,sphere", choice), "sphere");
	EXPECT_EQ(applyChoices("no-", choice), "no-");
	std::set<std::string> names;
	for (const DrawChoiceRow& row : drawChoiceRows())
	{
		EXPECT_TRUE(names.insert(row.name).second) << row.name;
		choice = {};
		choice.*row.member = false;
		EXPECT_EQ(applyChoices(row.name, choice), "");
		EXPECT_TRUE(choice.*row.member) << row.name;
		EXPECT_EQ(applyChoices(std::string("no-") + row.name, choice), "");
		EXPECT_FALSE(choice.*row.member) << row.name;
	}
	EXPECT_EQ(sizeof(DrawChoice), drawChoiceRows().size()) << "each choice has a row";
}
