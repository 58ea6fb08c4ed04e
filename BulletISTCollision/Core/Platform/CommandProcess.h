// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace ist
{
/// The arguments of main(), the program's own name included, in UTF-8.
std::vector<std::string> commandArguments(int argc, char** argv);

/// Prepares the process of a command. A limit on file sizes then makes a write fail, and does not end the program with an incomplete file.
/// A console of Windows shows UTF-8.
void prepareCommand();
}  // namespace ist
