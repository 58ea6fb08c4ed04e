// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/HandState.h"

#include <optional>
#include <string>
#include <vector>

namespace devicebridge
{
/// The motion of a hand over time.
struct HandMotion
{
	struct Frame
	{
		double time = 0;  ///< time [s], increasing
		HandState hand;
	};
	std::vector<Frame> frames;

	/// The hand at a time. At the time of a frame, and between two equal frames, it is that frame with all its bits. Between other frames,
	/// positions are interpolated linearly and orientations about one axis. A joint that one of the two frames lacks is not tracked. Before
	/// the first frame and after the last, it is that frame. Without frames no joint is tracked.
	HandState at(double time) const noexcept;
};

/// Whether two samples are equal to the last bit. Joints that are not tracked in both are equal.
bool isSameHand(const HandState& a, const HandState& b) noexcept;

/// Text of a motion: comma separated, with a header. The columns are `time`, `left` (0 or 1), and for each of the 26 joints `NAME_x, _y,
/// _z` [m], `_qx, _qy, _qz, _qw`, `_r` [m], in World. All eight are empty if the joint is not tracked. Names are those of OpenXR: palm,
/// wrist, thumb_metacarpal ... little_tip. Numbers keep all their bits.
std::string handMotionText(const HandMotion& motion);
/// Writes the whole file or none.
std::optional<ist::Error> saveHandMotion(const HandMotion& motion, const std::string& path);

/// Reads a motion. Columns are found by name; unknown columns and lines that begin with # are ignored. Refused as `NAME:LINE: COLUMN:
/// PROBLEM`: a missing or repeated column, a row whose number of cells differs from the header's, text that is not a finite number. Also
/// refused: times that do not increase, a quaternion further than 1e-3 from unit length, and a joint with some cells empty.
ist::Result<HandMotion> readHandMotion(const std::string& text, const std::string& name);
ist::Result<HandMotion> loadHandMotion(const std::string& path);
}  // namespace devicebridge
