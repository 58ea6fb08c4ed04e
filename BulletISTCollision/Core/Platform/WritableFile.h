// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <system_error>

namespace ist
{
/// A file that is being written: a new one beside the file that it will replace, or a device or a pipe in place. Functions return why they
/// failed.
class WritableFile
{
public:
	WritableFile() = default;
	/// Closes the file, and removes a new one that has replaced no other.
	~WritableFile();
	WritableFile(const WritableFile&) = delete;
	WritableFile& operator=(const WritableFile&) = delete;

	/// Creates a file beside `target`, which grants no more access than the present file does.
	std::error_code createBeside(const std::filesystem::path& target);
	std::error_code openInPlace(const std::filesystem::path& path);

	/// Writes some of the bytes, at least one; `written` is their number.
	std::error_code write(const std::byte* bytes, std::size_t size, std::size_t& written);
	/// Flushes the new file to the medium, closes it, and puts it in the place of `target` of createBeside().
	std::error_code replaceTarget();
	std::error_code close();

private:
	std::intptr_t m_file = -1;
	std::filesystem::path m_target, m_created;
};

/// Whether the path is that of a device or a pipe, which is written in place.
bool isDeviceOrPipe(const std::filesystem::path& path);
/// Target of symbolic links. On Windows, a link to a file that does not exist is its own target.
std::filesystem::path behindLinks(std::filesystem::path path);
/// Why a device or a pipe cannot be written, without opening it: that would wait for a pipe's reader, and closing it again would end the
/// reader's input. On Windows only writing itself finds out.
std::error_code whyNotWritableInPlace(const std::filesystem::path& path);
}  // namespace ist
