// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <string>

namespace ist
{
/// Machine instructions that a query is compiled for. All sets find the same pairs in the same order and compute each pair with the same
/// operations. Only the order of summation differs, with the number of lanes, so sums agree to about 1e-6. One set always gives the same
/// bits.
enum class InstructionSet
{
	Portable,  ///< plain C++; the only one on machines other than x86-64 and 64-bit ARM
	Baseline,  ///< x86-64: SSE2
	V3,        ///< x86-64-v3: AVX2; compiled without fused multiply-add, so that it agrees with the others
	V4,        ///< x86-64-v4: AVX-512
	Neon       ///< 64-bit ARM: NEON; four lanes, as Baseline, and the same bits
};
constexpr InstructionSet kInstructionSets[] = {
	InstructionSet::Portable, InstructionSet::Baseline, InstructionSet::V3, InstructionSet::V4, InstructionSet::Neon};

/// Name of the set: "portable", "baseline", "v3", "v4" or "neon".
const char* toString(InstructionSet set);
/// Whether this build contains the set and this machine can run it.
bool isAvailable(InstructionSet set);
InstructionSet bestInstructionSet();
/// The set named `name`, or the best one if `name` is null or empty. An error for an unknown name and for a set that cannot run here.
Result<InstructionSet> parseInstructionSet(const char* name);
/// The set that the environment variable BULLETHAPTICS_ISA chooses.
Result<InstructionSet> chosenInstructionSet();
}  // namespace ist
