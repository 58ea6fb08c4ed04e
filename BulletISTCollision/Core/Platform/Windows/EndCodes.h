// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
// Exit codes with which limitProcess() ends a process, and ChildProcess tells why. No program of ours has them.
constexpr unsigned long kOutOfTimeCode = 0xE1570001, kOutOfMemoryCode = 0xE1570002;
}  // namespace ist
