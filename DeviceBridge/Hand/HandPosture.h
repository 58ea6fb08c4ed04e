// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Drivers/Glove/GloveHand.h"

namespace devicebridge
{
/// Joint angles of a finger [rad]. Bends are positive towards the palm.
struct FingerPosture
{
	double knuckle = 0, middle = 0, end = 0;
	double aside = 0;  ///< angle towards the thumb
};

/// Joint angles of a thumb [rad]. The thumb of a glove rotates about the back of the hand only. This one also leaves the plane of the palm,
/// so that it can oppose the fingers.
struct ThumbPosture
{
	double palmar = 0;    ///< angle of the metacarpal, from along the fingers to out of the palm
	double radial = 0.7;  ///< angle of the metacarpal away from the index finger
	double roll = 0;      ///< angle about the metacarpal; 0: bends as a finger does, pi: towards the fingers if it points out of the palm
	double knuckle = 0, end = 0;
};

/// Joint angles of a hand and the pose of its wrist.
struct HandPosture
{
	FingerPosture index, middle, ring, little;
	ThumbPosture thumb;
	ist::Pose
		X_WR;  ///< pose of the wrist's joint frame in World; at the identity the straight fingers point along -z and the palm faces -y
};

/// The joints in this posture. The bones are those of gloveHand(); a left hand is the mirror image, in the wrist's frame, of a right one.
HandState posedHand(const HandPosture& posture, const GloveHandSize& size) noexcept;

/// The posture between `a` (u = 0) and `b` (u = 1). Angles and the wrist's position are interpolated linearly, the wrist's orientation
/// about one axis.
HandPosture between(const HandPosture& a, const HandPosture& b, double u) noexcept;
}  // namespace devicebridge
