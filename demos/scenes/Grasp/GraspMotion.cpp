// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/GraspMotion.h"

#include <algorithm>
#include <cmath>

using namespace ist;
using devicebridge::FingerPosture;
using devicebridge::GloveHandSize;
using devicebridge::HandPosture;
using devicebridge::HandState;

namespace scenes
{
namespace
{
constexpr double kEndBend = 0.35;       // bend of the last joints [rad]
constexpr double kThumbX = -0.012;      // x of a right hand's pinching thumb, for a hand with the model's size [m]
constexpr double kModelLength = 0.189;  // length of that hand [m]

/// A chain of two links in a plane. The second link has two bones with the fixed angle `kink` between them.
struct TwoLinks
{
	double first, second;  ///< lengths of the links; the second from end to end [m]
	double kinked;         ///< angle between the second's first bone and its chord

	TwoLinks(double a, double b, double c, double kink)
		: first(a),
		  second(std::sqrt(b * b + c * c + 2 * b * c * std::cos(kink))),
		  kinked(std::atan2(c * std::sin(kink), b + c * std::cos(kink)))
	{}

	/// Finds the angles at which the end is at `reach` in the direction `angle`: `base` is that of the first link, `bend` that of the joint
	/// to the second link's first bone. Both bend towards larger angles. Angles are in the plane [rad].
	void solve(double reach, double angle, double& base, double& bend) const
	{
		const double d = std::clamp(reach, std::fabs(first - second) + 1e-4, first + second - 1e-6);
		const double inner = std::acos(std::clamp((d * d - first * first - second * second) / (2 * first * second), -1.0, 1.0));
		base = angle - std::atan2(second * std::sin(inner), first + second * std::cos(inner));
		bend = std::max(0.0, inner - kinked);
	}
};
}  // namespace

double smoothShare(double time, double from, double to)
{
	const double u = std::clamp((time - from) / (to - from), 0.0, 1.0);
	return u * u * (3 - 2 * u);
}

HandPosture pinchPosture(const GloveHandSize& size, double gap, double depth, double middle)
{
	using namespace devicebridge;
	const HandState flat = posedHand({}, {false, size.length});
	const auto joint = [&flat](int i) -> const HandJoint& { return flat.joints[static_cast<std::size_t>(i)]; };
	const auto bone = [&](int i) { return distance(joint(i).position, joint(i + 1).position); };
	HandPosture p;
	FingerPosture* fingers[4] = {&p.index, &p.middle, &p.ring, &p.little};
	const int knuckles[4] = {kIndexProximal, kMiddleProximal, kRingProximal, kLittleProximal};
	for (int f = 0; f < 4; ++f)
	{
		const int k = knuckles[f];
		const TwoLinks links(bone(k), bone(k + 1), bone(k + 2), kEndBend);
		const double away = joint(k).position.z - (middle - 0.5 * gap - joint(k + 3).radius), down = depth + joint(k).position.y;
		links.solve(std::hypot(away, down), std::atan2(down, away), fingers[f]->knuckle, fingers[f]->middle);
		fingers[f]->end = kEndBend;
	}
	const int t = kThumbMetacarpal;
	const TwoLinks links(bone(t), bone(t + 1), bone(t + 2), kEndBend);
	const Vec3 base = joint(t).position, tip{kThumbX * size.length / kModelLength, -depth, middle + 0.5 * gap + joint(t + 3).radius};
	const double away = base.z - tip.z, aside = base.x - tip.x, down = base.y - tip.y;
	// The thumb is the mirror image of a finger: its first link leans away from the fingers.
	double lean = 0;
	const double level = std::copysign(std::hypot(away, aside), away);
	links.solve(std::hypot(level, down), std::atan2(down, -level), lean, p.thumb.knuckle);
	p.thumb.palmar = 3.14159265358979323846 - lean;
	p.thumb.radial = std::atan2(aside, std::fabs(away)) * (away < 0 ? -1 : 1);
	p.thumb.roll = 3.14159265358979323846;
	p.thumb.end = kEndBend;
	return p;
}

HandPosture GraspMotion::at(double time) const
{
	const double grip = smoothShare(time, kApproached, kClosed) * (1 - smoothShare(time, kPutDown, kOpened));
	// The height of the hand lets straight fingers reach a little deeper than the grip.
	const double scale = size.length / kModelLength, depth = 0.098 * scale, middle = -0.086 * scale;
	const double wide = std::min(width + open, 0.1 * scale), narrow = std::max(width - squeeze, -squeeze);
	HandPosture p = between(pinchPosture(size, wide, depth, middle), pinchPosture(size, narrow, depth, middle), grip);
	const double above = 0.07 * (1 - smoothShare(time, 0, kApproached) + smoothShare(time, kOpened, kOpened + 0.4));
	const double raised = lift * smoothShare(time, kClosed, kLifted) * (1 - smoothShare(time, kTurnedBack, kPutDown));
	const double turned = turn * smoothShare(time, kLifted, kTurned) * (1 - smoothShare(time, kShaken, kTurnedBack));
	const double whole = 2 * 3.14159265358979323846, inShake = std::clamp(time - kRested, 0.0, kShaken - kRested);
	const double swing = shake * std::sin(whole * frequency * inShake) * smoothShare(time, kRested, kRested + 0.1) *
		(1 - smoothShare(time, kShaken - 0.1, kShaken));
	const Vec3 fingers{0.012 * scale * (size.left ? 1 : -1), -depth, middle};  // meeting point of the fingers, in the wrist's frame
	const Mat3 R = rotationMatrix(quaternionFromRotationVector(turned * Vec3{1, 0.5, 0}));
	const Vec3 meet{gripX + swing, gripHeight + above + raised + 0.5 * swing, gripZ};
	p.X_WR = {R, meet - R * fingers};
	return p;
}
}  // namespace scenes
