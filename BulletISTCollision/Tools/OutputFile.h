// SPDX-License-Identifier: Zlib
#pragma once

#include <initializer_list>
#include <string>

namespace ist::tools
{
/// Checks, before the work begins, whether `output` can be written and differs from all input files, by whatever name. Returns kGood, or
/// prints a sentence on stderr and returns an exit code.
int checkOutput(const std::string& output, std::initializer_list<std::string> inputs);
/// Writes the whole file or none. If it cannot be written, prints a sentence on stderr and returns its exit code.
int writeText(const std::string& path, const std::string& text);
}  // namespace ist::tools
