// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Faces/ContactFaces.h"

namespace ist
{
/// A body that is flat where the other one meets it, as a half-space, and a box where a contact is on one of its sides. Its depth is exact
/// and linear there, so the columns on the other body's faces are exact, and so is what they press.
struct Foundation
{
	double volume = 0;  ///< share of the columns on the other body's faces in the volume
	/// Share that their pressure has, in place of the other field's: all where that presses along the same normal, and errs.
	double pressure = 0;

	/// `onOther`: faces of the other body, which lie below the side. `own`: faces of the side. Both in one frame.
	Foundation(const BodySurface& body, const BodySurface& other, const FaceList& onOther, const FaceList& own);
	/// What another foundation leaves.
	void leaveOut(const Foundation& another)
	{
		volume *= 1 - another.volume;
		pressure *= 1 - another.pressure;
	}
};

/// Each foundation takes its share of the weight of the other body's field, first that on B. `onA`, `onB`: Foundation::pressure.
inline void leanWeights(double onA, double onB, double& weightA, double& weightB)
{
	weightB += onB * weightA;
	weightA *= 1 - onB;
	weightA += onA * weightB;
	weightB *= 1 - onA;
}
}  // namespace ist
