// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandShape.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr uint32_t kSides = 24;
constexpr double kFlatness = 0.92, kWaist = 0.06;
constexpr double kClearance = 0.95;  // share of the space between neighbouring fingers that they fill
constexpr int kFirstParts[4] = {kIndex1, kMiddle1, kRing1, kPinky1};

/// Joins rings of points to a closed surface between the single points `begin` and `end`. A ring runs counter-clockwise about the direction
/// from `begin` to `end`.
Mesh closedTube(const std::vector<std::array<Vec3, kSides>>& rings, const Vec3& begin, const Vec3& end)
{
	Mesh mesh;
	mesh.vertices.push_back(begin);
	for (const auto& ring : rings) mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
	mesh.vertices.push_back(end);
	const uint32_t count = static_cast<uint32_t>(rings.size()), last = static_cast<uint32_t>(mesh.vertices.size() - 1);
	const auto at = [](uint32_t ring, uint32_t i) { return 1 + ring * kSides + i % kSides; };
	for (uint32_t i = 0; i < kSides; ++i)
	{
		mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
		for (uint32_t r = 0; r + 1 < count; ++r)
		{
			mesh.triangles.push_back({at(r, i), at(r, i + 1), at(r + 1, i + 1)});
			mesh.triangles.push_back({at(r, i), at(r + 1, i + 1), at(r + 1, i)});
		}
		mesh.triangles.push_back({at(count - 1, i), at(count - 1, i + 1), last});
	}
	return mesh;
}

/// A round cone along -z with a waist in its middle.
Mesh boneMesh(const HandShape::Bone& bone)
{
	constexpr int kCap = 5, kStraight = 8;
	std::vector<std::array<Vec3, kSides>> rings;
	const auto add = [&rings](double along, double radius) {
		auto& ring = rings.emplace_back();
		for (uint32_t i = 0; i < kSides; ++i)
		{
			// The angle turns about -z, from x to -y.
			const double angle = 2 * kPi * i / kSides;
			ring[i] = {radius * std::cos(angle), -kFlatness * radius * std::sin(angle), -along};
		}
	};
	const double lean = std::asin(std::clamp((bone.radius - bone.endRadius) / bone.length, -0.9, 0.9));
	// The caps meet the cone where it is tangent to their spheres.
	for (int i = 1; i < kCap; ++i)
	{
		const double angle = (kPi / 2 + lean) * i / kCap;
		add(-bone.radius * std::cos(angle), bone.radius * std::sin(angle));
	}
	const double from = bone.radius * std::sin(lean), to = bone.length + bone.endRadius * std::sin(lean);
	for (int i = 0; i <= kStraight; ++i)
	{
		const double u = double(i) / kStraight, narrow = 1 - kWaist * std::pow(std::sin(kPi * u), 2);
		add(from + u * (to - from), narrow * std::cos(lean) * (bone.radius + u * (bone.endRadius - bone.radius)));
	}
	for (int i = kCap - 1; i >= 1; --i)
	{
		const double angle = (kPi / 2 - lean) * i / kCap;
		add(bone.length + bone.endRadius * std::cos(angle), bone.endRadius * std::sin(angle));
	}
	return closedTube(rings, {0, 0, bone.radius}, {0, 0, -bone.length - bone.endRadius});
}

/// The z coordinate at x of the line through the knuckles.
double knuckleLine(const HandShape::Palm& palm, double x)
{
	for (int i = 0; i < 3; ++i)
		if (x < palm.knuckles[i + 1].x || i == 2)
		{
			const Vec3 &a = palm.knuckles[i], &b = palm.knuckles[i + 1];
			const double u = std::clamp((x - a.x) / (b.x - a.x), -0.5, 1.5);
			return a.z + u * (b.z - a.z);
		}
	return palm.knuckles[3].z;
}

Mesh palmMesh(const HandShape::Palm& palm)
{
	constexpr int kStations = 18;
	const double thickness = 1.15 * *std::max_element(palm.knuckleRadii, palm.knuckleRadii + 4);
	const double lower = palm.knuckles[0].x - palm.knuckleRadii[0], upper = palm.knuckles[3].x + palm.knuckleRadii[3];
	const double wristHalf = std::min(1.15 * palm.wristRadius, 0.5 * (upper - lower));
	const auto place = [&](double s, double across, double up) {
		const double middle = palm.wrist.x + s * (0.5 * (lower + upper) - palm.wrist.x),
					 half = wristHalf + std::sqrt(s) * (0.5 * (upper - lower) - wristHalf);
		const double x = middle + across * half, far = knuckleLine(palm, x);
		return Vec3{x, up * thickness, palm.wrist.z + s * (far - palm.wrist.z)};
	};
	std::vector<std::array<Vec3, kSides>> rings;
	for (int k = 1; k < kStations; ++k)
	{
		// The rings are dense at the ends, where the slab is rounded.
		const double s = 0.5 - 0.5 * std::cos(kPi * k / kStations);
		const double edge = std::min(1.0, std::min(s, 1 - s) / 0.12), round = std::sqrt(1 - (1 - edge) * (1 - edge));
		auto& ring = rings.emplace_back();
		for (uint32_t i = 0; i < kSides; ++i)
		{
			// A superellipse, flat above and below.
			const double angle = 2 * kPi * i / kSides, c = std::cos(angle), q = -std::sin(angle);
			const double across = std::copysign(std::pow(std::fabs(c), 0.55), c), up = std::copysign(std::pow(std::fabs(q), 0.7), q);
			ring[i] = place(s, (0.75 + 0.25 * round) * across, round * up);
		}
	}
	return closedTube(rings, place(0, 0, 0), place(1, 0, 0));
}

std::optional<Error> checkJoints(const HandState& hand)
{
	for (int i = 0; i < kHandJoints; ++i)
	{
		const HandJoint& joint = hand.joints[static_cast<std::size_t>(i)];
		const std::string which = "joint " + std::to_string(i) + " of the hand ";
		if (!joint.tracked) return Error{which + "is not tracked; all are needed to measure a hand"};
		if (!isFinite(joint.position) || !std::isfinite(joint.radius)) return Error{which + "has a place or a radius that is not finite"};
		if (!(joint.radius > 0)) return Error{which + "has no thickness: its radius must be positive"};
	}
	if (!isNearUnit(hand.joints[kPalm].orientation))
		return Error{"joint " + std::to_string(kPalm) +
			" of the hand, the palm, has an orientation that is no rotation: its quaternion is not of unit length"};
	return std::nullopt;
}

/// Reduces the radii of adjacent bones until they fit side by side.
void reserve(HandShape& shape)
{
	for (int level = 0; level < 3; ++level)
		for (int f = 0; f < 3; ++f)
		{
			HandShape::Bone &a = shape.bones[static_cast<std::size_t>(kFirstParts[f] + level)],
							&b = shape.bones[static_cast<std::size_t>(kFirstParts[f + 1] + level)];
			const double room = kClearance * (shape.palm.knuckles[f + 1].x - shape.palm.knuckles[f].x),
						 thick = std::max(a.radius, a.endRadius) + std::max(b.radius, b.endRadius);
			if (!(thick > room) || !(room > 0)) continue;
			for (HandShape::Bone* bone : {&a, &b}) bone->radius *= room / thick, bone->endRadius *= room / thick;
		}
}
}  // namespace

Result<HandShape> measureHand(const HandState& hand)
{
	if (auto error = checkJoints(hand)) return *error;
	const auto joint = [&hand](int i) -> const HandJoint& { return hand.joints[static_cast<std::size_t>(i)]; };
	HandShape shape;
	shape.left = hand.left;
	for (int part = 1; part < kHandParts; ++part)
	{
		const HandJoint &from = joint(handPartJoint(part)), &to = joint(handPartEnd(part));
		HandShape::Bone& bone = shape.bones[static_cast<std::size_t>(part)];
		bone = {distance(from.position, to.position), from.radius, to.radius};
		if (!(bone.length > std::fabs(bone.radius - bone.endRadius)))
			return Error{
				handPartName(part, hand.left) + " is shorter than the difference of the radii at its ends: no bone has that shape"};
	}
	const Pose X_PW = inverse(Pose{rotationMatrix(joint(kPalm).orientation), joint(kPalm).position});
	const auto inPalm = [&](int i) {
		const Vec3 p = X_PW * joint(i).position;
		return Vec3{hand.left ? -p.x : p.x, p.y, p.z};
	};
	HandShape::Palm& palm = shape.palm;
	palm.wrist = inPalm(kWrist);
	palm.wristRadius = joint(kWrist).radius;
	for (int f = 0; f < 4; ++f)
	{
		const HandJointIndex knuckle = handPartJoint(kFirstParts[f]);
		palm.knuckles[f] = inPalm(knuckle);
		if (!(palm.knuckles[f].z < palm.wrist.z))
			return Error{"joint " + std::to_string(knuckle) + " of the hand lies behind the wrist, along the palm's -z"};
		if (f > 0 && !(palm.knuckles[f].x > palm.knuckles[f - 1].x))
			return Error{
				"the knuckles are not in the order of a " + std::string(hand.left ? "left" : "right") + " hand: is it the other one?"};
	}
	reserve(shape);
	for (int f = 0; f < 4; ++f) palm.knuckleRadii[f] = shape.bones[static_cast<std::size_t>(kFirstParts[f])].radius;
	return shape;
}

Mesh handPartMesh(const HandShape& shape, int part)
{
	Mesh mesh = part == kHandPart ? palmMesh(shape.palm) : boneMesh(shape.bones[static_cast<std::size_t>(part)]);
	if (!shape.left) return mesh;
	for (Vec3& p : mesh.vertices) p.x = -p.x;
	for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
	return mesh;
}
}  // namespace devicebridge
