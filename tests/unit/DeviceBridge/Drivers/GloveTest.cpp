// SPDX-License-Identifier: Zlib
#include <filesystem>
#include <fstream>
#include <random>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Glove/GloveFrames.h"
#include "DeviceBridge/Drivers/Glove/GloveHand.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"
#include "tests/unit/DeviceBridge/Drivers/SerialGlove.h"

using namespace devicebridge;

namespace
{
constexpr double kPi = 3.14159265358979323846;

ist::Vec3 at(const HandState& hand, int joint) { return hand.joints[static_cast<std::size_t>(joint)].position; }
ist::Vec3 bone(const HandState& hand, int joint) { return at(hand, joint + 1) - at(hand, joint); }
double angleBetween(const ist::Vec3& a, const ist::Vec3& b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

GloveAngles randomAngles(std::mt19937_64& random)
{
	GloveAngles angles;
	std::uniform_real_distribution<double> angle(0.05, 1.4);
	for (double& a : angles) a = angle(random);
	return angles;
}

constexpr int kFirstJoints[4] = {kIndexMetacarpal, kMiddleMetacarpal, kRingMetacarpal, kLittleMetacarpal};
constexpr int kKnuckles[4] = {kIndexKnuckle, kMiddleKnuckle, kRingKnuckle, kLittleKnuckle};

GloveValues randomValues(std::mt19937_64& random)
{
	GloveValues values;
	for (auto& v : values) v = static_cast<std::uint8_t>(1 + random() % 255);
	return values;
}
}  // namespace

TEST(GloveHand, AFlatHandHasTheLengthThatWasAskedFor)
{
	const HandState hand = gloveHand({}, {false, 0.2});
	EXPECT_NEAR(at(hand, kMiddleTip).z, -0.2, 1e-12);
	for (const int first : kFirstJoints)
		for (int i = 1; i < 4; ++i) EXPECT_LT(norm(cross(bone(hand, first + i), ist::Vec3{0, 0, -1})), 1e-12);
	EXPECT_LT(at(hand, kThumbTip).x, at(hand, kIndexTip).x);  // the thumb of a right hand with the palm down is on the left
	for (const HandJoint& joint : hand.joints) EXPECT_TRUE(joint.tracked && joint.radius > 0.003);
}

TEST(GloveHand, AnglesBetweenBonesAreThoseOfTheSensors)
{
	std::mt19937_64 random(4);
	const HandState flat = gloveHand({}, {});
	for (int round = 0; round < 100; ++round)
	{
		const GloveAngles a = randomAngles(random);
		const HandState hand = gloveHand(a, {});
		for (int f = 0; f < 4; ++f)
		{
			const int first = kFirstJoints[f];
			const auto sensor = static_cast<std::size_t>(kKnuckles[f]);
			EXPECT_NEAR(angleBetween(bone(hand, first + 1), bone(hand, first + 2)), a[sensor + 1], 1e-9);
			EXPECT_NEAR(angleBetween(bone(hand, first + 2), bone(hand, first + 3)), a[sensor + 2], 1e-9);
		}
		EXPECT_NEAR(angleBetween(bone(hand, kThumbMetacarpal), bone(hand, kThumbProximal)), a[kThumbMetacarpalBend], 1e-9);
		EXPECT_NEAR(angleBetween(bone(hand, kThumbProximal), bone(hand, kThumbDistal)), a[kThumbBend], 1e-9);
		// Bones are rigid, and every frame points along its bone.
		for (int joint = kThumbMetacarpal; joint < kHandJoints - 1; ++joint)
		{
			const bool tip = joint == kThumbTip || joint == kIndexTip || joint == kMiddleTip || joint == kRingTip;
			if (tip || joint == kRingMetacarpal || joint == kLittleMetacarpal) continue;
			EXPECT_NEAR(norm(bone(hand, joint)), norm(bone(flat, joint)), 1e-12);
			const ist::Mat3 R = rotationMatrix(hand.joints[static_cast<std::size_t>(joint)].orientation);
			const bool metacarpal = joint >= kIndexMetacarpal && (joint - kIndexMetacarpal) % 5 == 0;
			EXPECT_LT(metacarpal ? 0 : angleBetween(R * ist::Vec3{0, 0, -1}, bone(hand, joint)), 1e-7) << joint;
		}
	}
}

TEST(GloveHand, FingersCurlInThePlaneOfTheirTips)
{
	std::mt19937_64 random(5);
	std::uniform_real_distribution<double> angle(0, 1.5);
	for (int round = 0; round < 50; ++round)
	{
		GloveAngles a{};
		for (const int knuckle : kKnuckles)
			for (int i = 0; i < 3; ++i) a[static_cast<std::size_t>(knuckle + i)] = angle(random);
		const HandState hand = gloveHand(a, {});
		for (int f = 0; f < 4; ++f)
		{
			// Closed form of a planar chain.
			ist::Vec3 tip = at(hand, kFirstJoints[f] + 1);
			double sum = 0;
			for (int i = 0; i < 3; ++i)
			{
				sum += a[static_cast<std::size_t>(kKnuckles[f] + i)];
				tip += norm(bone(hand, kFirstJoints[f] + 1 + i)) * ist::Vec3{0, -std::sin(sum), -std::cos(sum)};
			}
			EXPECT_LT(distance(tip, at(hand, kFirstJoints[f] + 4)), 1e-12);
		}
	}
}

TEST(GloveHand, SpreadingOpensTheAnglesBetweenNeighbours)
{
	GloveAngles a{};
	a[kMiddleIndexAbduction] = 0.2, a[kRingMiddleAbduction] = 0.15, a[kLittleRingAbduction] = 0.3, a[kThumbAbduction] = 0.25;
	const HandState hand = gloveHand(a, {}), flat = gloveHand({}, {});
	const auto between = [&](const HandState& h, int one, int other) { return angleBetween(bone(h, one), bone(h, other)); };
	EXPECT_NEAR(between(hand, kIndexProximal, kMiddleProximal), 0.2, 1e-9);
	EXPECT_NEAR(between(hand, kMiddleProximal, kRingProximal), 0.15, 1e-9);
	EXPECT_NEAR(between(hand, kRingProximal, kLittleProximal), 0.3, 1e-9);
	EXPECT_NEAR(between(hand, kThumbMetacarpal, kMiddleProximal) - between(flat, kThumbMetacarpal, kMiddleProximal), 0.25, 1e-9);
	EXPECT_GT(at(hand, kLittleTip).x - at(hand, kIndexTip).x, at(flat, kLittleTip).x - at(flat, kIndexTip).x);
}

TEST(GloveHand, LeftIsTheMirrorImageAndTheWristTurnsTheWholeHand)
{
	std::mt19937_64 random(6);
	const GloveAngles a = randomAngles(random);
	const HandState right = gloveHand(a, {false, 0.19}), left = gloveHand(a, {true, 0.19});
	for (int j = 0; j < kHandJoints; ++j)
	{
		const ist::Vec3 r = at(right, j), l = at(left, j);
		EXPECT_EQ((ist::Vec3{-r.x, r.y, r.z}), l);
		const ist::Vec3 forward = rotationMatrix(right.joints[static_cast<std::size_t>(j)].orientation) * ist::Vec3{0, 0, -1};
		const ist::Vec3 mirrored = rotationMatrix(left.joints[static_cast<std::size_t>(j)].orientation) * ist::Vec3{0, 0, -1};
		EXPECT_LT(distance({-forward.x, forward.y, forward.z}, mirrored), 1e-12);
	}
	GloveAngles straight = a;
	straight[kWristPitch] = straight[kWristYaw] = 0;
	const HandState before = gloveHand(straight, {});
	for (int i = 0; i < kHandJoints; ++i)
		for (int j = 0; j < i; ++j) EXPECT_NEAR(distance(at(right, i), at(right, j)), distance(at(before, i), at(before, j)), 1e-12);
	GloveAngles bent{};
	bent[kWristPitch] = 0.5;
	EXPECT_NEAR(at(gloveHand(bent, {}), kMiddleTip).y, -0.19 * std::sin(0.5), 1e-12);
	bent = {};
	bent[kWristYaw] = 0.3;
	EXPECT_LT(at(gloveHand(bent, {}), kMiddleTip).x, -0.04);
}

TEST(GloveFrames, FramesAreFoundAmongDamagedOnes)
{
	std::mt19937_64 random(8);
	for (const int sensors : {18, 22})
	{
		GloveFrames frames;
		int whole = 0, found = 0, wrong = 0;
		for (int i = 0; i < 3000; ++i)
		{
			const GloveValues values = randomValues(random);
			std::string bytes = "S";
			for (int k = 0; k < kGloveSensors; ++k)
				if (sensors == 22 || !isDistal(k)) bytes += static_cast<char>(values[static_cast<std::size_t>(k)]);
			bytes += '\0';
			const bool damaged = random() % 4 == 0;
			if (damaged) bytes.erase(random() % (bytes.size() - 1), 1);  // not the last byte: that would join two frames
			whole += !damaged;
			for (const char c : bytes)
			{
				if (!frames.take(static_cast<std::uint8_t>(c))) continue;
				++found;
				for (int k = 0; k < kGloveSensors; ++k)
				{
					const std::uint8_t wanted = sensors == 18 && isDistal(k) ? 0 : values[static_cast<std::size_t>(k)];
					wrong += frames.values()[static_cast<std::size_t>(k)] != wanted;
				}
			}
		}
		EXPECT_EQ(found, whole);
		EXPECT_EQ(wrong, 0);
		EXPECT_EQ(frames.dropped(), static_cast<std::uint64_t>(3000 - whole));
		EXPECT_EQ(frames.sensors(), sensors);
	}
}

TEST(GloveCalibration, TwoPosesGiveTheAnglesBack)
{
	std::mt19937_64 random(9);
	GloveValues flat, fist;
	for (std::size_t i = 0; i < flat.size(); ++i)
	{
		flat[i] = static_cast<std::uint8_t>(20 + random() % 60);
		fist[i] = static_cast<std::uint8_t>(flat[i] + 60 + random() % 100);
	}
	const auto made = calibrateGlove(flat, fist, true);
	ASSERT_TRUE(made) << made.error().message;
	const GloveAngles zero = made.value().angles(flat), closed = made.value().angles(fist);
	for (const double angle : zero) EXPECT_NEAR(angle, 0, 1e-12);
	for (const int knuckle : kKnuckles)
	{
		EXPECT_NEAR(closed[static_cast<std::size_t>(knuckle)], kPi / 2, 1e-12);
		EXPECT_NEAR(closed[static_cast<std::size_t>(knuckle + 1)], kPi / 2, 1e-12);
	}
	const auto again = readGloveCalibration(writeGloveCalibration(made.value()));
	ASSERT_TRUE(again) << again.error().message;
	EXPECT_EQ(again.value().gain, made.value().gain);
	EXPECT_EQ(again.value().offset, made.value().offset);

	// Without distal sensors these joints follow.
	GloveValues few = fist;
	for (int i = 0; i < kGloveSensors; ++i)
		if (isDistal(i)) few[static_cast<std::size_t>(i)] = 0;
	EXPECT_NEAR(made.value().angles(few)[kIndexEnd], kPi / 3, 1e-12);

	fist[kRingMiddle] = static_cast<std::uint8_t>(flat[kRingMiddle] + 3);
	const auto dead = calibrateGlove(flat, fist, true);
	ASSERT_FALSE(dead);
	EXPECT_NE(dead.error().message.find("ring_middle moves by 3"), std::string::npos) << dead.error().message;
}

TEST(GloveCalibration, RefusesFilesThatAreNone)
{
	const std::string good = writeGloveCalibration(roughGloveCalibration());
	ASSERT_TRUE(readGloveCalibration(good));
	const auto with = [&](const std::string& from, const std::string& to) {
		std::string text = good;
		return text.replace(text.find(from), from.size(), to);
	};
	for (const std::string& text :
		{std::string(), std::string("{}"), with("\"schema\": 1", "\"schema\": 2"), with("thumb_roll", "thumb_role"),
			with("\"offset\": 1.0", "\"offset\": \"1\""), with("\"gain\": 0", "\"gain\": 40"), good.substr(0, good.size() / 2)})
	{
		const auto read = readGloveCalibration(text);
		ASSERT_FALSE(read) << text;
		EXPECT_EQ(read.error().message.find("Not a glove calibration: "), 0U);
	}
}

TEST_F(GloveOnALine, JointsOfBothKindsArriveFromTheSerialLine)
{
	const std::string file = (std::filesystem::temp_directory_path() / ("glove" + std::to_string(getpid()) + ".json")).string();
	GloveCalibration calibration = roughGloveCalibration();
	for (std::size_t i = 0; i < calibration.gain.size(); ++i)
		calibration.offset[i] = 3.5 * static_cast<double>(i), calibration.gain[i] = 2e-3 + 1e-4 * static_cast<double>(i);
	std::ofstream(file) << writeGloveCalibration(calibration);
	std::mt19937_64 random(10);
	for (const int sensors : {18, 22})
	{
		SerialGlove glove(sensors);
		auto device = DeviceRegistry().open("glove:" + glove.path() + "?hand=left&calibration=" + file);
		ASSERT_TRUE(device) << device.error().message;
		EXPECT_EQ(device.value()->info().sensed, static_cast<unsigned>(kHandJointsSensed));
		EXPECT_EQ(device.value()->info().handedness, Handedness::Left);
		EXPECT_NE(device.value()->info().model.find(std::to_string(sensors)), std::string::npos);
		RealClock clock;
		for (int round = 0; round < 5; ++round)
		{
			const GloveValues values = randomValues(random);
			glove.set(values);
			glove.noisy = round % 2 == 1;
			const auto angle = [&](int i) {
				return calibration.gain[static_cast<std::size_t>(i)] *
					(values[static_cast<std::size_t>(i)] - calibration.offset[static_cast<std::size_t>(i)]);
			};
			DeviceState s;
			HandState hand;
			EXPECT_TRUE(within([&] {
				EXPECT_EQ(device.value()->read(clock.now(), s), DeviceStatus::Ok);
				EXPECT_TRUE(device.value()->readHand(hand));
				double error = 0;
				for (int f = 0; f < 4; ++f)
				{
					const double middle = angle(kKnuckles[f] + 1), end = sensors == 22 ? angle(kKnuckles[f] + 2) : 2.0 / 3 * middle;
					error = std::max(error,
						std::fabs(angleBetween(bone(hand, kFirstJoints[f] + 1), bone(hand, kFirstJoints[f] + 2)) - std::fabs(middle)));
					error = std::max(
						error, std::fabs(angleBetween(bone(hand, kFirstJoints[f] + 2), bone(hand, kFirstJoints[f] + 3)) - std::fabs(end)));
				}
				return error < 1e-9;
			}));
			EXPECT_TRUE(hand.left);
			EXPECT_TRUE(s.flags & kCalibrated);
		}
		const int before = glove.stops;
		device.value()->close();
		EXPECT_TRUE(within([&] { return glove.stops > before; }));
	}
	std::filesystem::remove(file);
}

TEST_F(GloveOnALine, APulledCableIsExplainedAndASilentGloveIsFrozen)
{
	SerialGlove glove(22);
	auto device = DeviceRegistry().open("glove:" + glove.path());
	ASSERT_TRUE(device) << device.error().message;
	DriverRun run(*device.value());
	EXPECT_TRUE(run.until([&] { return run.thread().faultCause() == FaultCause::None && run.thread().ticks() > 5; }));
	EXPECT_FALSE(run.thread().state().flags & kCalibrated);
	glove.silent = true;
	EXPECT_TRUE(run.until([&] { return run.thread().faultCause() == FaultCause::Frozen; }));
	glove.silent = false;
	EXPECT_TRUE(run.until([&] { return run.thread().faultCause() == FaultCause::None; }));
	run.expectLossIsSafe(
		*device.value(), [&] { glove.unplugged = true; }, false);
	EXPECT_NE(device.value()->complaint().find("hung up"), std::string::npos) << device.value()->complaint();
}

TEST_F(GloveOnALine, RefusesWhatIsNoneInASentence)
{
	PseudoTerminal mute;
#if defined(_WIN32)
	const std::string file = "NUL";
#else
	const std::string file = "/dev/null";
#endif
	const std::pair<std::string, const char*> wrong[] = {{"glove:", "/dev/ttyUSB0"}, {"glove:/nowhere/tty", "cannot open"},
		{"glove:" + file, "no serial line"}, {"glove:/dev/x?sensors=20", "18 or 22"}, {"glove:/dev/x?hand=both", "left or right"},
		{"glove:/dev/x?calibration=/nowhere/c.json", "/nowhere/c.json"}, {"glove:" + mute.path(), "sends no frames"}};
	for (const auto& [uri, word] : wrong)
	{
		const auto device = DeviceRegistry().open(uri);
		ASSERT_FALSE(device) << uri;
		EXPECT_NE(device.error().message.find(word), std::string::npos) << device.error().message;
	}
}
