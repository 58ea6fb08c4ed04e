// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/BvhHand.h"
#include "DeviceBridge/Hand/HandFromPoints.h"
#include "tests/unit/DeviceBridge/Hand/LightHand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

using namespace devicebridge;
using ist::Pose;
using ist::Vec3;

namespace
{
constexpr const char* kFingers[5] = {"Thumb", "Index", "Middle", "Ring", "Pinky"};
const HandPoints kPoints = pointsOf(posedHand({}, {}));

/// A hand at rest below hips, in centimetres: joints with three rotations, fingertips as end sites. `motion` is everything after the
/// hierarchy.
std::string bvh(const std::string& motion)
{
	std::ostringstream text;
	text.precision(17);
	const auto offset = [&](const Vec3& p) { text << "OFFSET " << 100 * p.x << " " << 100 * p.y << " " << 100 * p.z << "\n"; };
	text << "HIERARCHY\nROOT Hips\n{\nOFFSET 7 7 7\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\nJOINT "
			"rig:RightHand\n{\n";
	offset(kPoints[0]);
	text << "CHANNELS 3 Zrotation Xrotation Yrotation\n";
	for (size_t f = 0; f < 5; ++f)
	{
		for (size_t k = 0; k < 3; ++k)
		{
			const size_t i = 1 + 4 * f + k;
			text << "JOINT rig:RightHand" << kFingers[f] << k + 1 << "\n{\n";
			offset(kPoints[i] - kPoints[k == 0 ? 0 : i - 1]);
			text << "CHANNELS 3 Zrotation Xrotation Yrotation\n";
		}
		text << "End Site\n{\n";
		offset(kPoints[4 * f + 4] - kPoints[4 * f + 3]);
		text << "}\n}\n}\n}\n";
	}
	text << "}\n}\n" << motion;
	return text.str();
}
/// One frame: hips at (x, y, z) rotated by (z, x, y) degrees, the index finger's first joint likewise, and all else zero.
std::string frame(const char* hips, const char* index)
{
	std::string row = std::string(hips) + " 0 0 0";
	for (int joint = 0; joint < 15; ++joint) row += std::string(" ") + (joint == 3 ? index : "0 0 0");
	return row + "\n";
}
std::string problem(const std::string& text)
{
	const auto read = readBvhHand(text, "a.bvh");
	return read ? std::string() : read.error().message;
}
std::string replaced(std::string text, const std::string& from, const std::string& to)
{
	text.replace(text.find(from), from.size(), to);
	return text;
}
ist::Mat3 turn(const Vec3& by) { return rotationMatrix(ist::quaternionFromRotationVector(by)); }
}  // namespace

TEST(BvhHand, FindsThePointsThatItsAnglesSay)
{
	const auto read = readBvhHand(bvh("MOTION\nFrames: 3\nFrame Time: 0.02\n" + frame("0 0 0 0 0 0", "0 0 0") +
									  frame("10 20 30 40 -50 60", "0 0 0") + frame("0 0 0 0 0 0", "0 30 0")),
		"a.bvh");
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().frames.size(), 3u);
	EXPECT_NEAR(read.value().frames[2].time, 0.04, 1e-12);
	const double degree = 0.017453292519943295;
	const Pose X{turn({0, 0, 40 * degree}) * turn({-50 * degree, 0, 0}) * turn({0, 60 * degree, 0}), {0.1, 0.2, 0.3}};
	const Pose bent{turn({30 * degree, 0, 0}), {}};
	const HandPoints still = pointsOf(read.value().frames[0].hand), moved = pointsOf(read.value().frames[1].hand),
					 index = pointsOf(read.value().frames[2].hand);
	for (size_t i = 0; i < kHandPoints; ++i)
	{
		EXPECT_LT(distance(still[i], kPoints[i]), 1e-9) << i;
		EXPECT_LT(distance(moved[i], X * kPoints[i]), 1e-9) << i;
		const bool turns = i >= 5 && i <= 8;
		EXPECT_LT(distance(index[i], turns ? kPoints[5] + bent * (kPoints[i] - kPoints[5]) : kPoints[i]), 1e-9) << i;
	}
}

TEST(BvhHand, RefusesWithTheLine)
{
	const std::string motion = "MOTION\nFrames: 1\nFrame Time: 0.02\n" + frame("0 0 0 0 0 0", "0 0 0"), good = bvh(motion);
	EXPECT_EQ(problem(good), "");
	EXPECT_EQ(problem("hello"), "a.bvh:1: 'hello' where HIERARCHY should be");
	EXPECT_EQ(problem(replaced(good, "OFFSET 7", "OFFSET seven")), "a.bvh:4: 'seven' is not a finite number");
	EXPECT_EQ(problem(replaced(good, "Zrotation", "Wrotation")), "a.bvh:5: 'Wrotation' is no channel");
	EXPECT_NE(problem(replaced(good, "HandMiddle2", "HandCentral2")).find("there is no joint RightHandMiddle2"), std::string::npos);
	EXPECT_NE(problem(replaced(good, "Frames: 1", "Frames: 2")).find("the file ends too early"), std::string::npos);
	EXPECT_NE(problem(replaced(good, "Frames: 1", "Frames: -1")).find("whole and positive"), std::string::npos);
	EXPECT_NE(problem(replaced(good, "Time: 0.02", "Time: 0")).find("frame time"), std::string::npos);
	EXPECT_NE(problem(good.substr(0, good.size() / 3)).find("a.bvh:"), std::string::npos);
	EXPECT_FALSE(readBvhHand(good, "a.bvh", {true, 0.01, ""}));
	EXPECT_FALSE(readBvhHand(good, "a.bvh", {false, 0, ""}));
	EXPECT_FALSE(loadBvhHand("/nowhere/a.bvh"));
	for (size_t size = 0; size + 8 < good.size(); size += 97) EXPECT_FALSE(readBvhHand(good.substr(0, size), "a.bvh"));
}

TEST(BvhHand, TakesOneLineForAFrame)
{
	const std::string start = "MOTION\nFrames: 2\nFrame Time: 0.02\n", row = frame("0 0 0 0 0 0", "0 0 0");
	const auto lineOf = [](const std::string& text, size_t from) {
		return std::to_string(std::count(text.begin(), text.end(), '\n') + from);
	};
	const std::string line = lineOf(bvh(start), 1), after = lineOf(bvh(start), 2), third = lineOf(bvh(start), 3);
	EXPECT_EQ(problem(bvh(start + "\n" + row + "\r\n" + row + "\r\n \n")), "");
	// A frame has six numbers for the hips, three for the hand, and three for each of fifteen joints.
	EXPECT_EQ(problem(bvh(start + "1 2 3\n" + row + row)), "a.bvh:" + line + ": a frame has 54 numbers, and here are 3");
	EXPECT_EQ(problem(bvh(start + row + "7 " + row)), "a.bvh:" + after + ": a frame has 54 numbers, and here are 55");
	EXPECT_EQ(problem(bvh(start + row + row + row)), "a.bvh:" + third + ": '0' after the last frame");
	EXPECT_NE(problem(bvh(replaced(start, "0.02", "0.02 0") + row + row)).find("on the line of the frame time"), std::string::npos);
}

TEST(BvhHand, RefusesAHierarchyThatCannotMove)
{
	std::string text = bvh("MOTION\nFrames: 10000000\nFrame Time: 0.02\n");
	for (size_t at = text.find("CHANNELS"); at != std::string::npos; at = text.find("CHANNELS"))
		text.erase(at, text.find('\n', at) + 1 - at);
	EXPECT_NE(problem(text).find("no joint has a channel"), std::string::npos);
}
