// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <algorithm>
#include <cstdint>

namespace ist
{
/// Moves the ten lowest bits to every third place.
inline uint32_t spreadBits(uint32_t bits)
{
	bits = (bits | bits << 16) & 0x030000ff;
	bits = (bits | bits << 8) & 0x0300f00f;
	bits = (bits | bits << 4) & 0x030c30c3;
	return (bits | bits << 2) & 0x09249249;
}

/// Place on a Z-order curve through a box, of 1024 columns along each axis. Points whose places follow each other are mostly close
/// together. Points outside of the box count as on its border.
inline uint32_t placeOnCurve(const Vec3& p, const Box& box)
{
	constexpr double kColumns = 1024;
	const Vec3 size = box.size();
	uint32_t place = 0;
	for (int k = 0; k < 3; ++k)
	{
		const double share = size[k] > 0 ? (p[k] - box.lower[k]) / size[k] : 0;
		place |= spreadBits(uint32_t(std::clamp(share * kColumns, 0.0, kColumns - 1))) << k;
	}
	return place;
}
}  // namespace ist
