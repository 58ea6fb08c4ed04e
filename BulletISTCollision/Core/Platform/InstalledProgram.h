// SPDX-License-Identifier: Zlib
#pragma once

#include <filesystem>

namespace ist
{
/// What the names of programs end with.
extern const char* const kProgramEnding;
/// The shared library or program that contains the function at this address, without links; empty if it is not known.
std::filesystem::path fileOfFunction(const void* function);
/// Whether a path is that of a program that may be run: on POSIX, one that root or this user owns. Windows is not asked for the owner.
bool isTrustedProgram(const std::filesystem::path& program);
/// The importer program of the build or installation against which a program with the static library was linked; null if there is none.
const char* importerOfBuild();
}  // namespace ist
