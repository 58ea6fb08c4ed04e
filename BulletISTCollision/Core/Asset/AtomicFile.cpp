// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AtomicFile.h"

#include "BulletISTCollision/Core/Platform/FileError.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Core/Platform/WritableFile.h"

#include <algorithm>
#include <filesystem>

namespace ist
{
namespace
{
/// Returns the error of a failed write, which is null if `progress` has cancelled.
std::optional<std::error_code> writeAll(WritableFile& file, const std::byte* bytes, size_t size, const Progress& progress)
{
	constexpr size_t kChunk = size_t(1) << 22;
	for (size_t done = 0, written = 0; done < size; done += written)
	{
		if (progress && !progress("write", double(done) / double(size))) return std::error_code();
		if (const std::error_code failure = file.write(bytes + done, std::min(kChunk, size - done), written)) return failure;
	}
	if (progress && !progress("write", 1)) return std::error_code();
	return std::nullopt;
}

/// Why there can be no file at `path`, behind any symbolic links.
std::optional<Error> whyNoFile(const std::string& path)
{
	if (path.empty()) return Error{"the file to write has no name; give it one"};
	std::error_code reason;
	const std::filesystem::file_type there = std::filesystem::status(systemPath(path), reason).type();
	if (there == std::filesystem::file_type::directory)
		return fileError(path, "writing the file", std::make_error_code(std::errc::is_a_directory));
	if (there == std::filesystem::file_type::none) return fileError(path, "writing the file", reason);
	return std::nullopt;
}
}  // namespace

std::optional<Error> whyNotWritable(const std::string& path)
{
	if (isDeviceOrPipe(systemPath(path)))
	{
		const std::error_code failure = whyNotWritableInPlace(systemPath(path));
		return failure ? std::optional(fileError(path, "opening the file", failure)) : std::nullopt;
	}
	if (const std::optional<Error> reason = whyNoFile(path)) return reason;
	WritableFile file;
	const std::error_code failure = file.createBeside(behindLinks(systemPath(path)));
	return failure ? std::optional(fileError(path, "creating the file", failure)) : std::nullopt;
}

Result<size_t> writeFileAtomically(const std::string& path, const std::byte* bytes, size_t size, const Progress& progress)
{
	const bool inPlace = isDeviceOrPipe(systemPath(path));
	if (const std::optional<Error> reason = inPlace ? std::nullopt : whyNoFile(path)) return *reason;
	WritableFile file;
	if (const std::error_code failure = inPlace ? file.openInPlace(systemPath(path)) : file.createBeside(behindLinks(systemPath(path))))
		return fileError(path, inPlace ? "opening the file" : "creating the file", failure);
	std::optional<std::error_code> failure = writeAll(file, bytes, size, progress);
	if (!failure)
		if (const std::error_code last = inPlace ? file.close() : file.replaceTarget()) failure = last;
	if (!failure) return size;
	if (!*failure) return Error{"\"" + path + "\": the writing was cancelled; nothing was written", true};
	return fileError(path, "writing the file", *failure);
}

bool isSameFile(const std::string& path, const std::string& other)
{
	std::error_code unknown;
	if (isDeviceOrPipe(systemPath(path))) return false;
	const auto place = [&](const std::string& p) {
		return std::filesystem::weakly_canonical(std::filesystem::absolute(behindLinks(systemPath(p)), unknown), unknown);
	};
	return place(path) == place(other);
}
}  // namespace ist
