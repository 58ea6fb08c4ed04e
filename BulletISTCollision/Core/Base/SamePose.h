// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

namespace ist
{
/// Compares number by number, without a tolerance: a result for X is then valid for Y.
inline bool isSame(const Pose& X, const Pose& Y)
{
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
			if (X.rotation.m[i][j] != Y.rotation.m[i][j]) return false;
	return X.translation.x == Y.translation.x && X.translation.y == Y.translation.y && X.translation.z == Y.translation.z;
}
}  // namespace ist
