// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

namespace devicebridge
{
/// The files of data/devices, compiled into the library.
struct CarriedProfile
{
	const char* name;
	const char* text;
};
extern const CarriedProfile kCarriedProfiles[];
extern const std::size_t kCarriedProfileCount;
}  // namespace devicebridge
