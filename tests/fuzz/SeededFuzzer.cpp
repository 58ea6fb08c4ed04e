// SPDX-License-Identifier: Zlib
// Replaces libFuzzer where the compiler has none. It runs each file of the given folders unchanged, then as many mutations of them as
// -runs says, always the same ones. It follows no coverage, so it finds only severe faults. It ignores other options of libFuzzer.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/Invariants.h"

namespace
{
using Bytes = std::vector<std::uint8_t>;

std::vector<Bytes> filesOf(const std::vector<std::string>& folders)
{
	std::vector<std::string> paths;
	for (const std::string& folder : folders)
		for (const auto& entry : std::filesystem::directory_iterator(folder))
			if (entry.is_regular_file()) paths.push_back(entry.path().string());
	std::sort(paths.begin(), paths.end());
	std::vector<Bytes> files;
	for (const std::string& path : paths)
	{
		std::ifstream in(path, std::ios::binary);
		files.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
	}
	return files;
}

class Mutations
{
public:
	explicit Mutations(const std::vector<Bytes>& files) : m_files(files) {}

	Bytes next()
	{
		Bytes bytes = any();
		for (size_t k = 0; k <= below(4); ++k) mutate(bytes);
		return bytes;
	}

private:
	size_t below(size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(m_random); }
	const Bytes& any() { return m_files[below(m_files.size())]; }
	std::ptrdiff_t place(const Bytes& bytes) { return static_cast<std::ptrdiff_t>(below(bytes.size() + 1)); }

	void mutate(Bytes& bytes)
	{
		if (bytes.empty()) bytes.push_back('0');
		static constexpr std::string_view telling[] = {
			"-1", "0", "1e999", "nan", "99999999999999999999", "\"", "{", "[", "}\n", "\xff\xff\xff\xff", ",", "\n"};
		switch (below(6))
		{
		case 0: bytes[below(bytes.size())] ^= static_cast<std::uint8_t>(1u << below(8)); break;
		case 1: bytes.resize(below(bytes.size())); break;
		case 2:
		{
			const auto begin = bytes.begin() + place(bytes);
			bytes.erase(begin, begin + std::min<std::ptrdiff_t>(bytes.end() - begin, static_cast<std::ptrdiff_t>(1 + below(16))));
			break;
		}
		case 3:
		{
			const std::string_view word = telling[below(std::size(telling))];
			bytes.insert(bytes.begin() + place(bytes), word.begin(), word.end());
			break;
		}
		case 4:
		{
			const std::string_view word = telling[below(std::size(telling))];
			const size_t at = below(bytes.size());
			std::copy_n(word.begin(), std::min(word.size(), bytes.size() - at), bytes.begin() + static_cast<std::ptrdiff_t>(at));
			break;
		}
		default:  // the rest comes from another file
		{
			const Bytes& other = any();
			bytes.resize(below(bytes.size()));
			bytes.insert(bytes.end(), other.begin() + place(other), other.end());
		}
		}
	}

	const std::vector<Bytes>& m_files;
	std::mt19937_64 m_random{1};
};
}  // namespace

int main(int argc, char** argv)
{
	std::vector<std::string> folders;
	long runs = 1000;
	for (const std::string_view argument : std::vector<std::string_view>(argv + 1, argv + argc))
		if (argument.starts_with("-runs=")) runs = std::atol(argument.substr(6).data());
		else if (!argument.starts_with("-")) folders.emplace_back(argument);
	const std::vector<Bytes> files = filesOf(folders);
	fuzz::require(!files.empty(), "there are files to begin with");
	for (const Bytes& file : files) LLVMFuzzerTestOneInput(file.data(), file.size());
	Mutations mutations(files);
	for (long run = 0; run < runs; ++run)
	{
		const Bytes bytes = mutations.next();
		LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
	}
	std::printf("%zu files and %ld mutations of them\n", files.size(), runs);
	return 0;
}
