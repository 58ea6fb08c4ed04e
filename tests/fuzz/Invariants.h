// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

/// Properties that a fuzzer requires of a parser, in addition to what sanitizers see. Each function ends the process when a property is
/// violated.
namespace fuzz
{
inline void require(bool condition, const char* what)
{
	if (condition) return;
	std::fprintf(stderr, "broken invariant: %s\n", what);
	std::abort();
}

/// Returns true if there is a value. A refusal must give a reason.
template <class T> bool accepted(const ist::Result<T>& result)
{
	require(static_cast<bool>(result) || !result.error().message.empty(), "a refusal has a reason");
	return static_cast<bool>(result);
}

inline std::string text(const std::uint8_t* data, std::size_t size) { return {reinterpret_cast<const char*>(data), size}; }
}  // namespace fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
