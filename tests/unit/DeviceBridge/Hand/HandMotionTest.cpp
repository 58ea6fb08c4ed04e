// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandMotion.h"
#include "DeviceBridge/Hand/ContactPoseHands.h"
#include "DeviceBridge/Hand/HandFromPoints.h"
#include "tests/unit/DeviceBridge/Hand/LightHand.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <random>
#include <sstream>

using namespace devicebridge;
using ist::Vec3;

namespace
{
HandMotion someMotion()
{
	std::mt19937 random(4);
	HandMotion motion;
	for (int i = 0; i < 5; ++i)
	{
		motion.frames.push_back({0.1 * i, posedHand(randomPosture(random), {true, 0.181})});
		motion.frames.back().hand.joints[size_t(3 * i)].tracked = false;
	}
	return motion;
}
std::string replaced(std::string text, const std::string& from, const std::string& to)
{
	text.replace(text.find(from), from.size(), to);
	return text;
}
/// A file with one frame in which cell `index` (from 0) of the row is replaced.
std::string withCell(size_t index, const std::string& cell)
{
	HandMotion motion;
	motion.frames.push_back({0, posedHand({}, {})});
	const std::string text = handMotionText(motion);
	const size_t end = text.find('\n') + 1;
	std::istringstream cells(text.substr(end, text.size() - end - 1));
	std::string row;
	size_t i = 0;
	for (std::string one; std::getline(cells, one, ','); ++i) row += (i ? "," : "") + (i == index ? cell : one);
	return text.substr(0, end) + row + "\n";
}
std::string refusal(const std::string& text)
{
	const auto read = readHandMotion(text, "a.csv");
	return read ? std::string() : read.error().message;
}
}  // namespace

TEST(HandMotion, ReadsWhatItWroteToTheLastBit)
{
	const HandMotion motion = someMotion();
	const auto read = readHandMotion("# a comment\n\n" + handMotionText(motion), "a.csv");
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().frames.size(), motion.frames.size());
	for (size_t i = 0; i < motion.frames.size(); ++i)
	{
		const HandMotion::Frame &a = motion.frames[i], &b = read.value().frames[i];
		EXPECT_EQ(a.time, b.time);
		EXPECT_TRUE(b.hand.left);
		for (size_t j = 0; j < kHandJoints; ++j)
		{
			ASSERT_EQ(a.hand.joints[j].tracked, b.hand.joints[j].tracked);
			if (!a.hand.joints[j].tracked) continue;
			EXPECT_EQ(a.hand.joints[j].position, b.hand.joints[j].position);
			EXPECT_EQ(a.hand.joints[j].orientation.w, b.hand.joints[j].orientation.w);
			EXPECT_EQ(a.hand.joints[j].radius, b.hand.joints[j].radius);
		}
	}
}

TEST(HandMotion, FilesAreWrittenAndFoundAgain)
{
	const std::string path = (std::filesystem::temp_directory_path() / ("hand" + std::to_string(std::random_device()()) + ".csv")).string();
	ASSERT_FALSE(saveHandMotion(someMotion(), path));
	EXPECT_EQ(loadHandMotion(path).value().frames.size(), 5u);
	std::filesystem::remove(path);
	EXPECT_FALSE(loadHandMotion(path));
	EXPECT_TRUE(saveHandMotion(someMotion(), path + "/none/a.csv"));
}

TEST(HandMotion, RefusesWithLineAndColumn)
{
	EXPECT_EQ(refusal(withCell(0, "0")), "");
	EXPECT_EQ(refusal(withCell(2, "abc")), "a.csv:2: palm_x: 'abc' is not a finite number");
	EXPECT_EQ(refusal(withCell(3, "nan")), "a.csv:2: palm_y: 'nan' is not a finite number");
	EXPECT_EQ(refusal(withCell(4, "")), "a.csv:2: palm_z: is missing");
	EXPECT_EQ(refusal(withCell(8, "3")), "a.csv:2: palm_qw: the quaternion is not of unit length");
	EXPECT_EQ(refusal(withCell(1, "2")), "a.csv:2: left: must be 0 or 1");
	EXPECT_EQ(refusal(replaced(withCell(0, "0"), "thumb_tip_r", "thumb_r")), "a.csv:1: thumb_tip_r: the header lacks this column");
	const std::string text = withCell(0, "0");
	EXPECT_EQ(refusal(text + text.substr(text.find('\n') + 1)), "a.csv:3: time: does not grow");
	EXPECT_EQ(refusal(""), "a.csv:0: time: the file has no header");
	EXPECT_EQ(refusal(text + "1,0\n"), "a.csv:3: time: the row has 2 cells, and the header 210");
	EXPECT_EQ(refusal(text + "1,0" + std::string(8 * kHandJoints, ',') + "\n"), "");  // nothing is tracked
	EXPECT_EQ(
		refusal(text + "1,0" + std::string(8 * kHandJoints + 1, ',') + "\n"), "a.csv:3: time: the row has 211 cells, and the header 210");
	EXPECT_EQ(refusal(replaced(text, "palm_y", "palm_x")), "a.csv:1: palm_x: the header has this column twice");
}

TEST(HandMotion, IsContinuousBetweenItsFrames)
{
	HandMotion motion;
	HandPosture a, b;
	b.X_WR = {rotationMatrix(ist::quaternionFromRotationVector({0, 1, 0})), {0.3, 0, 0}};
	motion.frames = {{1, posedHand(a, {})}, {2, posedHand(b, {})}};
	const HandState middle = motion.at(1.5);
	EXPECT_NEAR(middle.joints[kWrist].position.x, 0.15, 1e-12);
	EXPECT_NEAR(rotationVector(middle.joints[kPalm].orientation).y, 0.5, 1e-9);
	EXPECT_EQ(motion.at(0).joints[kIndexTip].position, motion.frames[0].hand.joints[kIndexTip].position);
	EXPECT_EQ(motion.at(9).joints[kIndexTip].position, motion.frames[1].hand.joints[kIndexTip].position);
	motion.frames[0].hand.joints[kThumbTip].tracked = false;
	EXPECT_FALSE(motion.at(1.5).joints[kThumbTip].tracked);
	EXPECT_FALSE(HandMotion().at(0).joints[kPalm].tracked);
}

TEST(HandFromPoints, FindsTheFramesOfTheHandThatThePointsCameFrom)
{
	std::mt19937 random(8);
	for (int n = 0; n < 20; ++n)
	{
		const bool left = n % 2;
		HandPosture posture = randomPosture(random);
		for (FingerPosture* finger : {&posture.index, &posture.middle, &posture.ring, &posture.little}) finger->aside = 0;
		const HandState hand = posedHand(posture, {left, 0.19});
		const auto made = handFromPoints(pointsOf(hand), left);
		ASSERT_TRUE(made) << made.error().message;
		for (const int joint : {kThumbProximal, kIndexProximal, kMiddleIntermediate, kRingDistal, kLittleTip})
		{
			const HandJoint &a = hand.joints[size_t(joint)], &b = made.value().joints[size_t(joint)];
			EXPECT_LT(distance(a.position, b.position), 1e-9);
			const Vec3 wayA = rotationMatrix(a.orientation).column(2), wayB = rotationMatrix(b.orientation).column(2);
			EXPECT_LT(distance(wayA, wayB), 1e-6) << joint;
			EXPECT_NEAR(b.radius, a.radius, 0.2 * a.radius);
			// Fingers bend about the line of their knuckles, which is not exactly across the palm.
			const Vec3 acrossA = rotationMatrix(a.orientation).column(0), acrossB = rotationMatrix(b.orientation).column(0);
			EXPECT_GT(dot(acrossA, acrossB), joint >= kIndexMetacarpal ? 0.9 : -1.01) << joint;
		}
		EXPECT_TRUE(measureHand(made.value()));
	}
}

TEST(HandFromPoints, RefusesWhatIsNoHand)
{
	const HandPoints good = pointsOf(posedHand({}, {}));
	HandPoints bad = good;
	bad[7].x = std::numeric_limits<double>::infinity();
	EXPECT_EQ(handFromPoints(bad, false).error().message, "point 7 of the hand is not finite");
	bad = good;
	bad[12] = bad[11];
	EXPECT_EQ(handFromPoints(bad, false).error().message, "points 11 and 12 of the hand are in one place");
	bad = good;
	bad[17] = bad[0] + 2 * (bad[5] - bad[0]);
	EXPECT_NE(handFromPoints(bad, false).error().message.find("one line"), std::string::npos);
}

TEST(ContactPose, ReadsTheHandsThatAreThere)
{
	HandPosture posture;
	posture.index = {0.4, 0.3, 0.2, 0};
	const HandPoints points = pointsOf(posedHand(posture, {}));
	std::ostringstream joints;
	joints.precision(17);
	for (size_t i = 0; i < points.size(); ++i)
		joints << (i ? ", " : "") << "[" << points[i].x << ", " << points[i].y << ", " << points[i].z << "]";
	const std::string good = "{\"hands\": [{\"valid\": false}, {\"valid\": true, \"moving\": true, \"joints\": [" + joints.str() +
		"]}], \"frames\": []}";
	const auto read = readContactPose(good, "a.json");
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_FALSE(read.value().left);
	ASSERT_TRUE(read.value().right);
	EXPECT_TRUE(read.value().rightMoving);
	for (int i = 0; i < kHandPoints; ++i) EXPECT_EQ(pointsOf(*read.value().right)[size_t(i)], points[size_t(i)]);

	const auto problem = [](const std::string& text) { return readContactPose(text, "a.json").error().message; };
	EXPECT_EQ(problem("{}"), "a.json: hands: must be a list of two, left and right");
	EXPECT_EQ(problem("[1]"), "a.json: hands: must be a list of two, left and right");
	EXPECT_NE(problem("{\"hands\":\n[").find("line 2"), std::string::npos);
	EXPECT_NE(problem(replaced(good, "[[", "[[1e400, ")).find("a.json: is no JSON"), std::string::npos);
	EXPECT_EQ(problem("{\"hands\": [{\"valid\": false}, {}]}"), "a.json: hands[1].valid: is missing");
	EXPECT_EQ(problem("{\"hands\": [{\"valid\": true, \"joints\": []}, {\"valid\": false}]}"),
		"a.json: hands[0].joints: must be a list of 21 points");
	EXPECT_EQ(problem(replaced(good, "[[", "[[\"a\", ")), "a.json: hands[1].joints[0]: must be three numbers");
}
