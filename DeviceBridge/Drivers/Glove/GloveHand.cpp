// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Glove/GloveHand.h"

namespace devicebridge
{
namespace
{
// Dimensions of a right hand 189 mm long [m].
constexpr double kModelLength = 0.189;
constexpr ist::Vec3 kThumbBase{-0.025, -0.01, -0.02};
constexpr double kThumbAside = 0.7;  // angle of the straight thumb from the fingers [rad]
constexpr double kThumbBones[3] = {0.046, 0.032, 0.022}, kThumbRadii[4] = {0.014, 0.012, 0.010, 0.008};

struct FingerModel
{
	int first;    ///< joint index of its metacarpal
	int knuckle;  ///< sensor index of its knuckle
	double metacarpal, knuckleX, knuckleZ;
	double bones[3];
	double arch;  ///< share of the palm's arch
};
constexpr FingerModel kFingers[4] = {{kIndexMetacarpal, kIndexKnuckle, -0.016, -0.025, -0.086, {0.040, 0.022, 0.016}, 0},
	{kMiddleMetacarpal, kMiddleKnuckle, -0.005, -0.004, -0.088, {0.045, 0.026, 0.030}, 0},
	{kRingMetacarpal, kRingKnuckle, 0.006, 0.016, -0.083, {0.041, 0.026, 0.017}, 0.5},
	{kLittleMetacarpal, kLittleKnuckle, 0.016, 0.034, -0.074, {0.033, 0.018, 0.016}, 1}};
constexpr double kFingerRadii[5] = {0.013, 0.011, 0.009, 0.008, 0.007};

ist::Mat3 turn(const ist::Vec3& by) { return rotationMatrix(ist::quaternionFromRotationVector(by)); }
/// Rotation towards the palm: -z moves to -y.
ist::Mat3 bend(double angle) { return turn({-angle, 0, 0}); }
/// Rotation towards the thumb of a right hand: -z moves to -x.
ist::Mat3 sway(double angle) { return turn({0, angle, 0}); }

class Builder
{
public:
	explicit Builder(HandState& hand, double scale) : m_hand(hand), m_scale(scale) {}

	void put(int joint, const ist::Pose& X, double radius)
	{
		m_hand.joints[static_cast<std::size_t>(joint)] = {m_scale * X.translation, ist::quaternion(X.rotation), m_scale * radius, true};
	}
	/// Follows a bone and rotates at its end.
	static ist::Pose along(const ist::Pose& X, double length, const ist::Mat3& turning)
	{
		return {X.rotation * turning, X * ist::Vec3{0, 0, -length}};
	}

private:
	HandState& m_hand;
	double m_scale;
};

void addThumb(Builder& builder, const ist::Pose& X_WP, const GloveAngles& a)
{
	const ist::Mat3 base = sway(kThumbAside + a[kThumbAbduction]) * turn({0, 0, a[kThumbRoll]});
	const ist::Pose metacarpal = X_WP * ist::Pose{base, kThumbBase};
	const ist::Pose proximal = Builder::along(metacarpal, kThumbBones[0], bend(a[kThumbMetacarpalBend]));
	const ist::Pose distal = Builder::along(proximal, kThumbBones[1], bend(a[kThumbBend]));
	const ist::Pose poses[4] = {metacarpal, proximal, distal, Builder::along(distal, kThumbBones[2], {})};
	for (int i = 0; i < 4; ++i) builder.put(kThumbMetacarpal + i, poses[i], kThumbRadii[i]);
}

void addFinger(Builder& builder, const ist::Pose& X_WP, const FingerModel& f, double aside, const GloveAngles& a)
{
	const ist::Pose arched = X_WP * ist::Pose{bend(f.arch * a[kPalmArch]), {}};
	const ist::Pose metacarpal = arched * ist::Pose{{}, {f.metacarpal, 0, -0.02}};
	const auto angle = [&](int joint) { return a[static_cast<std::size_t>(f.knuckle + joint)]; };
	const ist::Pose proximal = arched * ist::Pose{sway(aside) * bend(angle(0)), {f.knuckleX, 0, f.knuckleZ}};
	const ist::Pose intermediate = Builder::along(proximal, f.bones[0], bend(angle(1)));
	const ist::Pose distal = Builder::along(intermediate, f.bones[1], bend(angle(2)));
	const ist::Pose poses[5] = {metacarpal, proximal, intermediate, distal, Builder::along(distal, f.bones[2], {})};
	for (int i = 0; i < 5; ++i) builder.put(f.first + i, poses[i], kFingerRadii[i]);
}

void mirror(HandState& hand)
{
	for (HandJoint& joint : hand.joints)
	{
		joint.position.x = -joint.position.x;
		joint.orientation.y = -joint.orientation.y;
		joint.orientation.z = -joint.orientation.z;
	}
}
}  // namespace

HandState gloveHand(const GloveAngles& a, const GloveHandSize& size) noexcept
{
	HandState hand;
	hand.left = size.left;
	Builder builder(hand, size.length / kModelLength);
	const ist::Pose palmRoot{sway(a[kWristYaw]) * bend(a[kWristPitch]), {}};
	builder.put(kWrist, palmRoot, 0.022);
	builder.put(kPalm, palmRoot * ist::Pose{{}, {-0.004, 0, -0.055}}, 0.018);
	addThumb(builder, palmRoot, a);
	const double index = a[kMiddleIndexAbduction], ring = -a[kRingMiddleAbduction], little = ring - a[kLittleRingAbduction];
	const double asides[4] = {index, 0, ring, little};
	for (int i = 0; i < 4; ++i) addFinger(builder, palmRoot, kFingers[i], asides[i], a);
	if (size.left) mirror(hand);
	return hand;
}
}  // namespace devicebridge
