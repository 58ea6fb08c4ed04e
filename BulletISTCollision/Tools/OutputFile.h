// SPDX-License-Identifier: Zlib
#pragma once

#include <initializer_list>
#include <string>

namespace ist::tools
{
/// Asked before the work: kGood, or a sentence on stderr and an exit code when `output` cannot be written or is one of the files that are
/// read, by whatever name.
int checkOutput(const std::string& output, std::initializer_list<std::string> inputs);
/// The whole file or none; a sentence on stderr and its exit code when it cannot be written.
int writeText(const std::string& path, const std::string& text);
}  // namespace ist::tools
