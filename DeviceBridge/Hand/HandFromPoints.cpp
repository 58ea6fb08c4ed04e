// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandFromPoints.h"

#include "DeviceBridge/Drivers/Glove/GloveHand.h"

#include <string>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr double kShortest = 1e-6;               // shortest bone [m]
constexpr int kFirstPoints[4] = {5, 9, 13, 17};  // points of index, middle, ring and little finger
constexpr HandJointIndex kMetacarpals[4] = {kIndexMetacarpal, kMiddleMetacarpal, kRingMetacarpal, kLittleMetacarpal};

HandJointIndex jointOf(int point)
{
	if (point == 0) return kWrist;
	if (point < 5) return static_cast<HandJointIndex>(kThumbMetacarpal + point - 1);
	return static_cast<HandJointIndex>(kMetacarpals[(point - 5) / 4] + 1 + (point - 5) % 4);
}

/// Orientation with -z along `way` and x as near as possible to `across`.
Quaternion frame(const Vec3& way, const Vec3& across, const Vec3& back)
{
	const Vec3 z = -normalized(way);
	Vec3 y = cross(z, across);
	if (!(norm(y) > 0.2 * norm(across))) y = back - dot(back, z) * z;
	y = normalized(y);
	const Vec3 x = cross(y, z);
	return quaternion(Mat3{{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}});
}

std::optional<Error> check(const HandPoints& p)
{
	for (int i = 0; i < kHandPoints; ++i)
	{
		if (!isFinite(p[size_t(i)])) return Error{"point " + std::to_string(i) + " of the hand is not finite"};
		if (i == 0) continue;
		const int before = i % 4 == 1 ? 0 : i - 1;
		if (!(distance(p[size_t(i)], p[size_t(before)]) > kShortest))
			return Error{"points " + std::to_string(before) + " and " + std::to_string(i) + " of the hand are in one place"};
	}
	if (!(norm(cross(p[5] - p[0], p[17] - p[0])) > kShortest * norm(p[5] - p[0])))
		return Error{"points 0, 5 and 17 of the hand, the wrist and two knuckles, lie in one line"};
	return std::nullopt;
}

void setRadii(const HandPoints& p, HandState& hand)
{
	const double length = distance(p[0], p[9]) + distance(p[9], p[10]) + distance(p[10], p[11]) + distance(p[11], p[12]);
	const HandState model = gloveHand({}, {hand.left, length});
	for (size_t i = 0; i < kHandJoints; ++i) hand.joints[i].radius = model.joints[i].radius;
}
}  // namespace

Result<HandState> handFromPoints(const HandPoints& p, bool left)
{
	if (auto error = check(p)) return *error;
	HandState hand;
	hand.left = left;
	const Vec3 across = normalized(left ? p[5] - p[17] : p[17] - p[5]),
			   back = (left ? 1.0 : -1.0) * normalized(cross(p[5] - p[0], p[17] - p[0]));
	const auto put = [&](HandJointIndex joint, const Vec3& place, const Vec3& way) {
		hand.joints[size_t(joint)] = {place, frame(way, across, back), 0, true};
	};
	put(kWrist, p[0], p[9] - p[0]);
	put(kPalm, 0.5 * (p[0] + p[9]), p[9] - p[0]);
	for (int f = 0; f < 4; ++f)
	{
		const Vec3& knuckle = p[size_t(kFirstPoints[f])];
		put(kMetacarpals[f], p[0] + 0.25 * (knuckle - p[0]), knuckle - p[0]);
	}
	for (int i = 1; i < kHandPoints; ++i)
	{
		const bool tip = i % 4 == 0;
		put(jointOf(i), p[size_t(i)], tip ? p[size_t(i)] - p[size_t(i - 1)] : p[size_t(i + 1)] - p[size_t(i)]);
	}
	setRadii(p, hand);
	return hand;
}

HandPoints pointsOf(const HandState& hand) noexcept
{
	HandPoints points;
	for (int i = 0; i < kHandPoints; ++i) points[size_t(i)] = hand.joints[size_t(jointOf(i))].position;
	return points;
}
}  // namespace devicebridge
