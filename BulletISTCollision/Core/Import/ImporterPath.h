// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace ist
{
/// Path of the importer program, the first that exists of:
/// 1. the value of the environment variable BULLETHAPTICS_IMPORT, which need not exist;
/// 2. the folder bullethaptics-VERSION beside the library or program that contains this function, or in the folder of libraries of the
///    prefix that it was installed or moved to;
/// 3. the build tree or installation against which a program with the static library was linked;
/// 4. the prefix for which the library was configured.
/// Programs that another user owns, neither this one nor root, are not taken from 2 to 4. Empty if there is none.
std::string importerPath();
}  // namespace ist
