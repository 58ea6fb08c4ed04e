// SPDX-License-Identifier: Zlib
#pragma once

#include <openxr/openxr.h>

#include <mutex>

/// State that the mock runtime shares with the test that has loaded the same file.
struct MockOpenXr
{
	std::mutex mutex;
	XrHandJointLocationEXT joints[2][XR_HAND_JOINT_COUNT_EXT] = {};  // left, right
	XrVector3f palmVelocity[2] = {}, palmTurning[2] = {};
	bool active[2] = {true, true};
	bool hasHeadless = true, hasHeadset = true, tracksHands = true, gone = false, exiting = false;
	int instances = 0, sessions = 0, trackers = 0, begun = 0, misuse = 0;
};

extern "C" __attribute__((visibility("default"))) MockOpenXr* mockOpenXr();
