// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/HandState.h"

#include <optional>
#include <string>
#include <vector>

namespace devicebridge
{
/// Hands over time.
struct HandMotion
{
	struct Frame
	{
		double time = 0;  ///< [s], growing
		HandState hand;
	};
	std::vector<Frame> frames;

	/// At the time of a frame and between two that are the same: the frame, to the last bit. Between others: places along lines, directions
	/// about one axis; a joint that one of the two lacks is not tracked. Before the first and after the last: these. Empty: no joint is
	/// tracked.
	HandState at(double time) const noexcept;
};

/// Whether two samples are the same to the last bit. Joints that are not tracked say nothing.
bool isSameHand(const HandState& a, const HandState& b) noexcept;

/// Comma separated text with a header: `time`, `left` (0 or 1), and for each of the 26 joints `NAME_x, _y, _z` [m], `_qx, _qy, _qz, _qw`,
/// `_r` [m], in World; all eight empty where the joint is not tracked. Names: palm, wrist, thumb_metacarpal ... little_tip, as OpenXR has
/// them. To the last bit.
std::string handMotionText(const HandMotion& motion);
/// The whole file or none.
std::optional<ist::Error> saveHandMotion(const HandMotion& motion, const std::string& path);

/// Columns are found by name, unknown ones and lines that begin with # ignored. Refused as `NAME:LINE: COLUMN: PROBLEM`: a column that is
/// missing or there twice, a row that has not as many cells as the header, what is no finite number, times that do not grow, a quaternion
/// further than 1e-3 from unit length, a joint that is half there.
ist::Result<HandMotion> readHandMotion(const std::string& text, const std::string& name);
ist::Result<HandMotion> loadHandMotion(const std::string& path);
}  // namespace devicebridge
