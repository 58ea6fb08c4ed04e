// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/OutputFile.h"

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Tools/Commands.h"

#include <filesystem>

namespace ist::tools
{
int checkOutput(const std::string& output, std::initializer_list<std::string> inputs)
{
	if (output == "-") return fail("\"-\" would be standard output, which is not written to here; name a file (./- for one of that name)");
	std::error_code missing;
	for (const std::string& input : inputs)
		if (std::filesystem::is_regular_file(systemPath(input), missing) &&
			std::filesystem::equivalent(systemPath(input), systemPath(output), missing))
			return fail("\"" + output + "\" is the file that is read; name another one to write");
	const std::optional<Error> obstacle = whyNotWritable(output);
	return obstacle ? fail(obstacle->message) : kGood;
}

int writeText(const std::string& path, const std::string& text)
{
	const Result<size_t> written = writeFileAtomically(path, reinterpret_cast<const std::byte*>(text.data()), text.size());
	return written ? kGood : fail(written.error().message);
}
}  // namespace ist::tools
