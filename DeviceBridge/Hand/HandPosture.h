// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Drivers/Glove/GloveHand.h"

namespace devicebridge
{
/// Bends are positive towards the palm [rad].
struct FingerPosture
{
	double knuckle = 0, middle = 0, end = 0;
	double aside = 0;  ///< towards the thumb
};

/// The thumb of a glove turns about the back of the hand only; this one also leaves the plane of the palm, and so can stand against the
/// fingers [rad].
struct ThumbPosture
{
	double palmar = 0;    ///< of the metacarpal, from along the fingers to out of the palm
	double radial = 0.7;  ///< of the metacarpal, away from the index finger
	double roll =
		0;  ///< about the metacarpal; 0 bends the thumb as a finger is bent, pi towards the fingers when it stands out of the palm
	double knuckle = 0, end = 0;
};

/// Joint angles of a hand and the place of its wrist.
struct HandPosture
{
	FingerPosture index, middle, ring, little;
	ThumbPosture thumb;
	ist::Pose X_WR;  ///< of the wrist's joint frame in World; at the identity the straight fingers point along -z and the palm faces -y
};

/// The joints in this posture. Bones as gloveHand() has them; a left hand is the mirror image, in the wrist's frame, of a right one.
HandState posedHand(const HandPosture& posture, const GloveHandSize& size) noexcept;

/// From `a` (u = 0) to `b` (u = 1): angles linearly, the wrist along a line with a turn about one axis.
HandPosture between(const HandPosture& a, const HandPosture& b, double u) noexcept;
}  // namespace devicebridge
