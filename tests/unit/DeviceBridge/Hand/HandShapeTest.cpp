// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "tests/unit/ClosedMesh.h"
#include "tests/unit/DeviceBridge/Hand/LightHand.h"

#include <gtest/gtest.h>

#include <limits>

using namespace devicebridge;
using ist::Vec3;

namespace
{
HandShape shapeOf(bool left, double length) { return measureHand(posedHand({}, {left, length})).value(); }
}  // namespace

TEST(HandParts, HaveTheNamesAndIdsOfGrab)
{
	EXPECT_EQ(handPartName(kHandPart, false), "R_Hand");
	EXPECT_EQ(handPartId(kHandPart, false), 22);
	EXPECT_EQ(handPartId(kHandPart, true), 21);
	EXPECT_EQ(handPartName(kIndex1, false), "R_Index1");
	EXPECT_EQ(handPartId(kIndex1, false), 41);
	EXPECT_EQ(handPartName(kPinky2, true), "L_Pinky2");
	EXPECT_EQ(handPartId(kPinky2, true), 33);
	EXPECT_EQ(handPartName(kThumb3, false), "R_Thumb3");
	EXPECT_EQ(handPartId(kThumb3, false), 55);
	EXPECT_EQ(handPartId(kThumb3, true), 40);
	int neighbours = 0;
	for (int a = 0; a < kHandParts; ++a)
		for (int b = 0; b < a; ++b) neighbours += areNeighbours(a, b);
	EXPECT_EQ(neighbours, 15);
}

TEST(HandShape, MeshesAreClosedAndGrowWithTheHand)
{
	for (const bool left : {false, true})
		for (int part = 0; part < kHandParts; ++part)
		{
			const ist::Mesh small = handPartMesh(shapeOf(left, 0.15), part), large = handPartMesh(shapeOf(left, 0.21), part);
			EXPECT_TRUE(isClosed(small)) << part;
			const double volume = massProperties(small).volume;
			EXPECT_GT(volume, 1e-6) << part;
			EXPECT_NEAR(massProperties(large).volume / volume, std::pow(0.21 / 0.15, 3), 1e-6) << part;
		}
}

TEST(HandShape, BoneHasTheVolumeOfARoundConeWithoutItsWaist)
{
	const HandShape shape = shapeOf(false, 0.189);
	for (int part = 1; part < kHandParts; ++part)
	{
		const HandShape::Bone& b = shape.bones[static_cast<std::size_t>(part)];
		// Volume by slices of the union of all balls between the two ends.
		double whole = 0;
		constexpr int kSlices = 4000, kBalls = 400;
		const double lower = -b.radius, upper = b.length + b.endRadius, step = (upper - lower) / kSlices;
		for (int i = 0; i < kSlices; ++i)
		{
			double widest = 0;
			for (int k = 0; k <= kBalls; ++k)
			{
				const double u = double(k) / kBalls, r = b.radius + u * (b.endRadius - b.radius),
							 off = lower + (i + 0.5) * step - u * b.length;
				widest = std::max(widest, r * r - off * off);
			}
			whole += 3.14159265358979 * widest * step;
		}
		const double volume = massProperties(handPartMesh(shape, part)).volume;
		// A flat section has 92 % of the area, the waist removes at most 12 % of the straight part, and the corners of the mesh some
		// percent.
		EXPECT_LT(volume, 0.92 * whole) << part;
		EXPECT_GT(volume, 0.8 * whole) << part;
	}
}

TEST(HandShape, LeftIsTheMirrorImageOfRight)
{
	for (int part = 0; part < kHandParts; ++part)
	{
		const auto right = massProperties(handPartMesh(shapeOf(false, 0.19), part)),
				   left = massProperties(handPartMesh(shapeOf(true, 0.19), part));
		EXPECT_NEAR(left.volume, right.volume, 1e-9 * right.volume);
		EXPECT_NEAR(left.centerOfMass.x, -right.centerOfMass.x, 1e-12);
		EXPECT_NEAR(left.centerOfMass.z, right.centerOfMass.z, 1e-12);
	}
}

TEST(HandShape, StraightFingersDoNotTouchEachOther)
{
	const HandState hand = posedHand({}, {false, 0.189});
	const HandShape shape = shapeOf(false, 0.189);
	std::vector<ist::Mesh> meshes;
	for (int part = 0; part < kHandParts; ++part)
	{
		const HandJoint& joint = hand.joints[static_cast<std::size_t>(handPartJoint(part))];
		meshes.push_back(transformed(handPartMesh(shape, part), {rotationMatrix(joint.orientation), joint.position}));
	}
	for (int a = 0; a < kHandParts; ++a)
	{
		const ist::MeshDistance distance(meshes[static_cast<std::size_t>(a)]);
		for (int b = 1; b < kHandParts; ++b)
		{
			if (a == b || areNeighbours(a, b)) continue;
			for (const Vec3& p : meshes[static_cast<std::size_t>(b)].vertices) EXPECT_FALSE(distance.contains(p)) << a << " " << b;
		}
	}
}

TEST(HandShape, RefusesAHandThatItCannotMeasure)
{
	HandState hand = posedHand({}, {false, 0.19});
	HandState bad = hand;
	bad.joints[kRingDistal].tracked = false;
	EXPECT_NE(measureHand(bad).error().message.find("joint 19 of the hand is not tracked"), std::string::npos);
	bad = hand;
	bad.joints[kThumbTip].position.x = std::numeric_limits<double>::quiet_NaN();
	EXPECT_FALSE(measureHand(bad));
	bad = hand;
	bad.joints[kIndexTip].radius = 0;
	EXPECT_FALSE(measureHand(bad));
	bad = hand;
	bad.joints[kIndexIntermediate].position = bad.joints[kIndexProximal].position;
	EXPECT_NE(measureHand(bad).error().message.find("R_Index1"), std::string::npos);
	bad = hand;
	bad.joints[kPalm].orientation.w *= 1.1;
	bad.joints[kPalm].orientation.x *= 1.1;
	bad.joints[kPalm].orientation.y *= 1.1;
	bad.joints[kPalm].orientation.z *= 1.1;
	EXPECT_NE(measureHand(bad).error().message.find("unit length"), std::string::npos);
	bad.joints[kPalm].orientation = {0, 0, 0, 0};
	EXPECT_FALSE(measureHand(bad));
	bad = hand;
	bad.left = true;
	EXPECT_NE(measureHand(bad).error().message.find("other"), std::string::npos);
}

TEST(HandPosture, BonesKeepTheirLengthsAndPartsReachTheirJoints)
{
	std::mt19937 random(5);
	const HandModel model = [] {
		HandModel m;
		m.shape = shapeOf(true, 0.18);
		for (int i = 0; i < kHandParts; ++i)
			m.parts[static_cast<std::size_t>(i)].centre = massProperties(handPartMesh(m.shape, i)).centerOfMass;
		return m;
	}();
	for (int n = 0; n < 20; ++n)
	{
		const HandState hand = posedHand(randomPosture(random), {true, 0.18});
		const HandPartPoses poses = handPartPoses(model, hand);
		for (int part = 1; part < kHandParts; ++part)
		{
			const auto i = static_cast<std::size_t>(part);
			ASSERT_TRUE(poses.known[i]);
			ASSERT_TRUE(isRigid(poses.X_WB[i], 1e-9));
			const Vec3 from = poses.X_WB[i] * -model.parts[i].centre,
					   to = poses.X_WB[i] * (Vec3{0, 0, -model.shape.bones[i].length} - model.parts[i].centre);
			EXPECT_LT(distance(from, hand.joints[static_cast<std::size_t>(handPartJoint(part))].position), 1e-9);
			EXPECT_LT(distance(to, hand.joints[static_cast<std::size_t>(handPartEnd(part))].position), 1e-9);
		}
	}
}

TEST(HandPosture, IsTheGlovesWhereTheThumbLiesInThePalm)
{
	HandPosture p;
	p.index = {0.3, 0.5, 0.2, 0.1};
	p.little = {0.1, 0.2, 0.3, -0.2};
	GloveAngles a{};
	a[kIndexKnuckle] = 0.3, a[kIndexMiddle] = 0.5, a[kIndexEnd] = 0.2, a[kMiddleIndexAbduction] = 0.1;
	a[kLittleKnuckle] = 0.1, a[kLittleMiddle] = 0.2, a[kLittleEnd] = 0.3, a[kLittleRingAbduction] = 0.2;
	const HandState ours = posedHand(p, {}), glove = gloveHand(a, {});
	for (int i = 0; i < kHandJoints; ++i)
		EXPECT_LT(distance(ours.joints[static_cast<std::size_t>(i)].position, glove.joints[static_cast<std::size_t>(i)].position), 1e-12)
			<< i;
}

TEST(HandPosture, PalmarThumbStandsOutOfThePalm)
{
	HandPosture p;
	p.thumb = {1.5707963267948966, 0, 0, 0, 0};
	const HandState hand = posedHand(p, {});
	const Vec3 way = hand.joints[kThumbTip].position - hand.joints[kThumbMetacarpal].position;
	EXPECT_NEAR(way.y, -norm(way), 1e-12);
}
