// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/InstructionSet.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Tuning/ExpectedError.h"
#include "BulletISTCollision/Core/Tuning/TuneSettings.h"
#include "tests/unit/Core/Mesh/RandomShapes.h"
#include "tests/unit/TestEnvironment.h"

#include <gtest/gtest.h>

#include <cstdlib>

using namespace ist;

namespace
{
/// Sets the environment variable and restores it.
class Choice
{
public:
	explicit Choice(const char* value)
	{
		if (const char* old = std::getenv(kName)) m_old = old, m_had = true;
		setenv(kName, value, 1);
	}
	~Choice() { m_had ? setenv(kName, m_old.c_str(), 1) : unsetenv(kName); }

private:
	static constexpr const char* kName = "BULLETHAPTICS_ISA";
	std::string m_old;
	bool m_had = false;
};
}  // namespace

TEST(InstructionSet, NamesAreParsed)
{
	for (const InstructionSet set : kInstructionSets)
	{
		const Result<InstructionSet> parsed = parseInstructionSet(toString(set));
		ASSERT_EQ(bool(parsed), isAvailable(set)) << toString(set);
		if (parsed) EXPECT_EQ(parsed.value(), set);
		else EXPECT_NE(parsed.error().message.find("cannot run"), std::string::npos);
	}
	EXPECT_TRUE(isAvailable(InstructionSet::Portable));
	EXPECT_TRUE(isAvailable(bestInstructionSet()));
	EXPECT_EQ(parseInstructionSet(nullptr).value(), bestInstructionSet());
	EXPECT_EQ(parseInstructionSet("").value(), bestInstructionSet());
	EXPECT_NE(parseInstructionSet("avx9000").error().message.find("unknown"), std::string::npos);
}

TEST(InstructionSet, TheBestOneIsThatOfTheMachine)
{
	EXPECT_STREQ(toString(InstructionSet::Neon), "neon");
#if defined(__aarch64__)
	EXPECT_EQ(bestInstructionSet(), InstructionSet::Neon);
	EXPECT_FALSE(isAvailable(InstructionSet::Baseline));
#elif defined(__x86_64__)
	EXPECT_TRUE(isAvailable(InstructionSet::Baseline));
	EXPECT_NE(bestInstructionSet(), InstructionSet::Portable);
	EXPECT_FALSE(isAvailable(InstructionSet::Neon));
#endif
}

TEST(InstructionSet, TheEnvironmentChooses)
{
	{
		const Choice portable("portable");
		EXPECT_EQ(chosenInstructionSet().value(), InstructionSet::Portable);
	}
	const Choice wrong("avx9000");
	EXPECT_FALSE(chosenInstructionSet());
	std::vector<MomentEllipsoid> ball(1);
	ball[0].R = 1;
	ball[0].density = 1;
	makeRound(ball[0]);
	InnerSphereTree body;
	body.law = buildBallTree(ball);
	QueryWorkspace workspace;
	const OverlapResult r = queryOverlap(body, body, Pose{}, workspace);
	EXPECT_EQ(r.status, QueryStatus::InstructionSet);
	EXPECT_EQ(r.total.pairs, 0);
	EXPECT_NE(std::string(toString(r.status)).find("BULLETHAPTICS_ISA"), std::string::npos);
	QueryWorkspace forced({}, InstructionSet::Portable);
	EXPECT_EQ(queryOverlap(body, body, Pose{}, forced).total.pairs, 1);
}

TEST(InstructionSet, AWrongChoiceIsNotBlamedOnTheBody)
{
	const Mesh box = makeBoxMesh({1, 1, 1});
	BuildOptions options;
	options.maxSpheres = 20;
	const Result<InnerSphereTree> tree = buildTree(box, options);
	ASSERT_TRUE(tree);
	const Choice wrong("avx9000");
	const Result<TuneSettings> tuned = measureSettings(tree.value(), tree.value(), 0.2);
	ASSERT_FALSE(tuned);
	const Result<InnerSphereTree> built = buildTreeToError(box, 0.5, options);
	ASSERT_FALSE(built);
	for (const std::string& message : {tuned.error().message, built.error().message})
	{
		EXPECT_NE(message.find("BULLETHAPTICS_ISA"), std::string::npos) << message;
		EXPECT_NE(message.find("avx9000"), std::string::npos) << message;
	}
}
