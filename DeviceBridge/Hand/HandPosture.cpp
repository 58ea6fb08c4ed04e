// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandPosture.h"

namespace devicebridge
{
namespace
{
ist::Mat3 turn(const ist::Vec3& by) { return rotationMatrix(ist::quaternionFromRotationVector(by)); }

/// Converts angles, with the sign of a right hand, to the glove's own order. The glove gives the side angles of ring and little finger as
/// differences.
GloveAngles gloveAngles(const HandPosture& p)
{
	GloveAngles a{};
	const auto bend = [&a](int knuckle, const FingerPosture& f) {
		a[static_cast<std::size_t>(knuckle)] = f.knuckle;
		a[static_cast<std::size_t>(knuckle + 1)] = f.middle;
		a[static_cast<std::size_t>(knuckle + 2)] = f.end;
	};
	bend(kIndexKnuckle, p.index);
	bend(kMiddleKnuckle, p.middle);
	bend(kRingKnuckle, p.ring);
	bend(kLittleKnuckle, p.little);
	a[kMiddleIndexAbduction] = p.index.aside;
	a[kRingMiddleAbduction] = -p.ring.aside;
	a[kLittleRingAbduction] = p.ring.aside - p.little.aside;
	return a;
}

void poseThumb(const ThumbPosture& t, HandState& hand)
{
	HandJoint* joints = &hand.joints[kThumbMetacarpal];
	double bones[3];
	for (int i = 0; i < 3; ++i) bones[i] = distance(joints[i].position, joints[i + 1].position);
	const ist::Mat3 bends[3] = {turn({0, 0, t.roll}), turn({-t.knuckle, 0, 0}), turn({-t.end, 0, 0})};
	ist::Mat3 frame = turn({0, t.radial, 0}) * turn({-t.palmar, 0, 0});
	for (int i = 0; i < 3; ++i)
	{
		frame = frame * bends[i];
		joints[i].orientation = joints[i + 1].orientation = quaternion(frame);
		joints[i + 1].position = joints[i].position - bones[i] * frame.column(2);
	}
}
}  // namespace

HandState posedHand(const HandPosture& posture, const GloveHandSize& size) noexcept
{
	HandState hand = gloveHand(gloveAngles(posture), {false, size.length});
	poseThumb(posture.thumb, hand);
	hand.left = size.left;
	if (size.left)
		for (HandJoint& joint : hand.joints)
		{
			joint.position.x = -joint.position.x;
			joint.orientation.y = -joint.orientation.y;
			joint.orientation.z = -joint.orientation.z;
		}
	moveHand(hand, posture.X_WR);
	return hand;
}

HandPosture between(const HandPosture& a, const HandPosture& b, double u) noexcept
{
	const auto mix = [u](double x, double y) { return x + u * (y - x); };
	const auto finger = [&](const FingerPosture& x, const FingerPosture& y) {
		return FingerPosture{mix(x.knuckle, y.knuckle), mix(x.middle, y.middle), mix(x.end, y.end), mix(x.aside, y.aside)};
	};
	HandPosture out;
	out.index = finger(a.index, b.index);
	out.middle = finger(a.middle, b.middle);
	out.ring = finger(a.ring, b.ring);
	out.little = finger(a.little, b.little);
	out.thumb = {mix(a.thumb.palmar, b.thumb.palmar), mix(a.thumb.radial, b.thumb.radial), mix(a.thumb.roll, b.thumb.roll),
		mix(a.thumb.knuckle, b.thumb.knuckle), mix(a.thumb.end, b.thumb.end)};
	out.X_WR.translation = a.X_WR.translation + u * (b.X_WR.translation - a.X_WR.translation);
	const ist::Vec3 way = rotationVector(quaternion(b.X_WR.rotation * transpose(a.X_WR.rotation)));
	out.X_WR.rotation = turn(u * way) * a.X_WR.rotation;
	return out;
}
}  // namespace devicebridge
