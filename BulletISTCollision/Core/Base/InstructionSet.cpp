// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/InstructionSet.h"

#include <cstdlib>
#include <cstring>

namespace ist
{
const char* toString(InstructionSet set)
{
	switch (set)
	{
	case InstructionSet::Portable: return "portable";
	case InstructionSet::Baseline: return "baseline";
	case InstructionSet::V3: return "v3";
	case InstructionSet::V4: return "v4";
	case InstructionSet::Neon: return "neon";
	}
	return "unknown";
}

bool isAvailable(InstructionSet set)
{
	switch (set)
	{
	case InstructionSet::Portable: return true;
#if defined(__x86_64__)
	case InstructionSet::Baseline: return true;
	case InstructionSet::V3:
		return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
			__builtin_cpu_supports("fma") && __builtin_cpu_supports("popcnt");
	case InstructionSet::V4:
		return isAvailable(InstructionSet::V3) && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
			__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512cd");
#elif defined(__aarch64__)
	case InstructionSet::Neon: return true;
#endif
	default: break;
	}
	return false;
}

InstructionSet bestInstructionSet()
{
	InstructionSet best = InstructionSet::Portable;
	for (const InstructionSet set : kInstructionSets)
		if (isAvailable(set)) best = set;
	return best;
}

Result<InstructionSet> parseInstructionSet(const char* name)
{
	if (!name || !*name) return bestInstructionSet();
	for (const InstructionSet set : kInstructionSets)
	{
		if (std::strcmp(name, toString(set)) != 0) continue;
		if (isAvailable(set)) return set;
		return Error{std::string("this machine cannot run the instruction set '") + name + "'"};
	}
	return Error{std::string("unknown instruction set '") + name + "': portable, baseline, v3, v4 or neon"};
}

Result<InstructionSet> chosenInstructionSet()
{
	const Result<InstructionSet> named = parseInstructionSet(std::getenv("BULLETHAPTICS_ISA"));
	return named ? named : Error{"BULLETHAPTICS_ISA: " + named.error().message};
}
}  // namespace ist
