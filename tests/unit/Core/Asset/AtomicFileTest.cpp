// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AtomicFile.h"

#include "BulletISTCollision/Core/Platform/MappedFile.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#if !defined(_WIN32)
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#endif
#include <unistd.h>

namespace ist
{
namespace
{
#if defined(_WIN32)
constexpr const char* kNoDevice = "NUL";
#else
constexpr const char* kNoDevice = "/dev/null";
#endif

/// Gives each test its own folder and removes it afterwards.
class AtomicFile : public testing::Test
{
protected:
	void SetUp() override
	{
		std::filesystem::remove_all(m_folder);
		std::filesystem::create_directories(m_folder);
	}
	void TearDown() override { std::filesystem::remove_all(m_folder); }

	std::string at(const char* name) const { return (m_folder / name).string(); }
	std::ptrdiff_t entries() const
	{
		return std::distance(std::filesystem::directory_iterator(m_folder), std::filesystem::directory_iterator());
	}
	static Result<size_t> write(const std::string& path, const std::string& text, const Progress& progress = {})
	{
		return writeFileAtomically(path, reinterpret_cast<const std::byte*>(text.data()), text.size(), progress);
	}
	static std::string content(const std::string& path)
	{
		std::ifstream in(path, std::ios::binary);
		return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
	}

	const std::filesystem::path m_folder = std::filesystem::path(testing::TempDir()) / ("ist_whole_file_" + std::to_string(::getpid()));
};

TEST_F(AtomicFile, WritesAndReplaces)
{
	ASSERT_TRUE(write(at("a"), "one"));
	ASSERT_TRUE(write(at("a"), "another"));
	EXPECT_EQ(content(at("a")), "another");
	EXPECT_EQ(entries(), 1);
	const Result<MappedFile> mapped = MappedFile::open(at("a"));
	ASSERT_TRUE(mapped);
	EXPECT_EQ(std::string(reinterpret_cast<const char*>(mapped.value().bytes()), mapped.value().size()), "another");
}

TEST_F(AtomicFile, AnEmptyFileIsReadAsNoBytes)
{
	ASSERT_TRUE(write(at("empty"), ""));
	const Result<MappedFile> mapped = MappedFile::open(at("empty"));
	ASSERT_TRUE(mapped) << mapped.error().message;
	EXPECT_EQ(mapped.value().size(), 0u);
}

TEST_F(AtomicFile, AFileWithoutANameIsRefused)
{
	EXPECT_TRUE(whyNotWritable(""));
	const Result<size_t> written = write("", "text");
	ASSERT_FALSE(written);
	EXPECT_NE(written.error().message.find("no name"), std::string::npos);
}

TEST_F(AtomicFile, AnUnwritablePathIsSaidAndLeavesNothing)
{
	const Result<size_t> missing = write(at("none/file"), "text");
	ASSERT_FALSE(missing);
	EXPECT_NE(missing.error().message.find("none/file"), std::string::npos);
	std::filesystem::create_directory(at("folder"));
	const Result<size_t> folder = write(at("folder"), "text");
	ASSERT_FALSE(folder);
	EXPECT_NE(folder.error().message.find("directory"), std::string::npos);
	EXPECT_EQ(entries(), 1);
}

TEST_F(AtomicFile, WhatCannotBeWrittenIsSaidBeforehandAsAfterwards)
{
	std::filesystem::create_directory(at("folder"));
	ASSERT_TRUE(write(at("there"), "old"));
	for (const char* name : {"none/file", "folder"})
	{
		const std::optional<Error> obstacle = whyNotWritable(at(name));
		ASSERT_TRUE(obstacle) << name;
		EXPECT_EQ(obstacle->message, write(at(name), "text").error().message);
	}
	for (const char* name : {"new", "there"}) EXPECT_FALSE(whyNotWritable(at(name))) << name;
	EXPECT_FALSE(whyNotWritable(kNoDevice));
	EXPECT_EQ(content(at("there")), "old");
	EXPECT_EQ(entries(), 2);
}

TEST_F(AtomicFile, ThreadsThatWriteTheSameFileDoNotMixTheirBytes)
{
	const auto writeOften = [this](char letter) {
		for (int i = 0; i < 20; ++i)
		{
			const Result<size_t> written = write(at("a"), std::string(100'000, letter));
			EXPECT_TRUE(written);
			const Result<MappedFile> there = MappedFile::open(at("a"));
			ASSERT_TRUE(there) << there.error().message;
			const std::byte* const bytes = there.value().bytes();
			ASSERT_EQ(there.value().size(), 100'000u);
			EXPECT_TRUE(std::all_of(bytes, bytes + 100'000, [bytes](std::byte b) { return b == bytes[0]; }));
		}
	};
	std::thread other(writeOften, 'b');
	writeOften('a');
	other.join();
	EXPECT_EQ(entries(), 1);
}

TEST_F(AtomicFile, CancellingKeepsTheOldFile)
{
	ASSERT_TRUE(write(at("a"), "old"));
	for (double stopAt : {0.0, 0.5, 1.0})
	{
		double last = -1;
		const Result<size_t> cancelled = write(at("a"), std::string(20'000'000, 'x'), [&](const char* stage, double fraction) {
			EXPECT_STREQ(stage, "write");
			EXPECT_GE(fraction, last);
			last = fraction;
			return fraction < stopAt;
		});
		ASSERT_FALSE(cancelled);
		EXPECT_TRUE(cancelled.error().cancelled);
		EXPECT_GE(last, stopAt);
		EXPECT_EQ(content(at("a")), "old");
		EXPECT_EQ(entries(), 1);
	}
}

TEST_F(AtomicFile, WhatIsWrittenToTheNullDeviceIsGone)
{
	EXPECT_TRUE(write(kNoDevice, "text"));
	EXPECT_EQ(entries(), 0);
	EXPECT_FALSE(isSameFile(kNoDevice, kNoDevice));
}

TEST_F(AtomicFile, AMappedFileIsReplacedAndItsBytesStay)
{
	ASSERT_TRUE(write(at("a"), "old"));
	{
		const Result<MappedFile> mapped = MappedFile::open(at("a"));
		ASSERT_TRUE(mapped) << mapped.error().message;
		const Result<size_t> written = write(at("a"), "new");
		ASSERT_TRUE(written) << written.error().message;
		EXPECT_EQ(std::string(reinterpret_cast<const char*>(mapped.value().bytes()), mapped.value().size()), "old");
		EXPECT_EQ(content(at("a")), "new");
	}
	// Windows keeps what was mapped until the next file is written there.
	ASSERT_TRUE(write(at("a"), "newer"));
	EXPECT_EQ(content(at("a")), "newer");
	EXPECT_EQ(entries(), 1);
}

TEST_F(AtomicFile, NamesAreUtf8)
{
	const std::string name = utf8Path(m_folder) +
		"/K\xC3\xB6rper_\xE7\x90\x83.ist";  // an umlaut, and a letter that no code page of Europe has
	ASSERT_TRUE(write(name, "text"));
	const Result<MappedFile> mapped = MappedFile::open(name);
	ASSERT_TRUE(mapped) << mapped.error().message;
	EXPECT_EQ(mapped.value().size(), 4u);
	EXPECT_TRUE(std::filesystem::exists(systemPath(name)));
	EXPECT_EQ(utf8Path(systemPath(name)), name);
	EXPECT_EQ(entries(), 1);
}

// Links, access rights, devices, pipes and limits of POSIX.
#if !defined(_WIN32)
TEST_F(AtomicFile, ALinkStaysALink)
{
	ASSERT_TRUE(write(at("target"), "old"));
	std::filesystem::create_symlink(at("target"), at("link"));
	ASSERT_TRUE(write(at("link"), "new"));
	EXPECT_TRUE(std::filesystem::is_symlink(at("link")));
	EXPECT_EQ(content(at("target")), "new");
}

TEST_F(AtomicFile, ALinkToNothingYetStaysALink)
{
	std::filesystem::create_directory(at("folder"));
	std::filesystem::create_symlink("folder/second", at("first"));
	std::filesystem::create_symlink("target", at("folder/second"));
	EXPECT_FALSE(whyNotWritable(at("first")));
	ASSERT_TRUE(write(at("first"), "new"));
	EXPECT_TRUE(std::filesystem::is_symlink(at("first")));
	EXPECT_TRUE(std::filesystem::is_symlink(at("folder/second")));
	EXPECT_EQ(content(at("folder/target")), "new");

	std::filesystem::create_symlink("none/target", at("astray"));
	EXPECT_TRUE(whyNotWritable(at("astray")));
	EXPECT_FALSE(write(at("astray"), "new"));
	EXPECT_TRUE(std::filesystem::is_symlink(at("astray")));
}

TEST_F(AtomicFile, LinksInACircleAreRefused)
{
	std::filesystem::create_symlink("there", at("here"));
	std::filesystem::create_symlink("here", at("there"));
	EXPECT_TRUE(whyNotWritable(at("here")));
	EXPECT_FALSE(write(at("here"), "new"));
	EXPECT_TRUE(std::filesystem::is_symlink(at("here")));
	EXPECT_EQ(entries(), 2);
}

TEST_F(AtomicFile, WhoMayReadAFileStaysAsItWas)
{
	const mode_t mask = ::umask(022);
	for (const unsigned mode : {0600u, 0640u, 0644u, 0664u, 0400u})
	{
		ASSERT_TRUE(write(at("a"), "old"));
		ASSERT_EQ(::chmod(at("a").c_str(), mode), 0);
		ASSERT_TRUE(write(at("a"), "new", [&](const char*, double) {
			for (const auto& entry : std::filesystem::directory_iterator(m_folder)) EXPECT_EQ(unsigned(entry.status().permissions()), mode);
			return true;
		}));
		struct stat now;
		ASSERT_EQ(::stat(at("a").c_str(), &now), 0);
		EXPECT_EQ(now.st_mode & 0777, mode);
		EXPECT_EQ(content(at("a")), "new");
	}
	ASSERT_TRUE(write(at("fresh"), "new"));
	EXPECT_EQ(unsigned(std::filesystem::status(at("fresh")).permissions()), 0644u);
	::umask(mask);
}

TEST_F(AtomicFile, NamesMayBeAsLongAsTheSystemAllows)
{
	const std::string name(255, 'n'), tooLong(256, 'n');
	ASSERT_TRUE(write(at(name.c_str()), "text"));
	EXPECT_EQ(content(at(name.c_str())), "text");
	EXPECT_TRUE(whyNotWritable(at(tooLong.c_str())));
	EXPECT_FALSE(write(at(tooLong.c_str()), "text"));
}

TEST_F(AtomicFile, OneFileIsKnownByAllOfItsNames)
{
	std::filesystem::create_directory(at("folder"));
	std::filesystem::create_symlink("file", at("link"));
	std::filesystem::create_directory_symlink(m_folder, at("folder/up"));
	for (const bool there : {false, true})
	{
		if (there)
		{
			ASSERT_TRUE(write(at("file"), "text"));
		}
		for (const char* name : {"file", "./file", "folder/../file", "link", "folder/up/file", "folder/up/link"})
			EXPECT_TRUE(isSameFile(at("file"), at(name))) << name << ' ' << there;
		EXPECT_TRUE(isSameFile(at("file"), std::filesystem::relative(at("file")).string()));
		EXPECT_FALSE(isSameFile(at("file"), at("other")));
		EXPECT_FALSE(isSameFile(at("file"), at("folder/file")));
	}
	EXPECT_FALSE(isSameFile("/dev/null", "/dev/null"));
}

TEST_F(AtomicFile, ADeviceIsWrittenInPlaceAndAFullOneIsSaid)
{
	if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
	const Result<size_t> full = write("/dev/full", "text");
	ASSERT_FALSE(full);
	EXPECT_NE(full.error().message.find("/dev/full"), std::string::npos);
	EXPECT_NE(full.error().message.find("No space left"), std::string::npos);
	EXPECT_TRUE(write("/dev/null", "text"));
	EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST_F(AtomicFile, AskingWhetherAPipeIsWritableDoesNotEndItsReading)
{
	ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
	EXPECT_FALSE(whyNotWritable(at("pipe")));  // also true without a reader
	std::string read;
	std::thread reader([&] { read = content(at("pipe")); });
	EXPECT_FALSE(whyNotWritable(at("pipe")));
	EXPECT_TRUE(write(at("pipe"), "text"));
	reader.join();
	EXPECT_EQ(read, "text");
}

TEST_F(AtomicFile, APipeIsRefusedAtOnce)
{
	ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
	std::string refusal;
	std::atomic<bool> refused = false;
	std::thread reader([&] {
		const Result<MappedFile> mapped = MappedFile::open(at("pipe"));
		if (!mapped) refusal = mapped.error().message;
		refused = true;
	});
	for (int i = 0; i < 1000 && !refused; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
	EXPECT_TRUE(refused);
	// A writer releases a reader that waits.
	const int writer = refused ? -1 : ::open(at("pipe").c_str(), O_WRONLY);
	reader.join();
	if (writer >= 0) ::close(writer);
	EXPECT_NE(refusal.find("is not a file"), std::string::npos) << refusal;
}

// A limit on the file size stands for a full disk: it cuts a write in the middle.
TEST_F(AtomicFile, AFileThatGrowsTooLargeLeavesTheOldOne)
{
	ASSERT_TRUE(write(at("a"), "old"));
	rlimit before;
	ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
	const auto handler = std::signal(SIGXFSZ, SIG_IGN);
	const rlimit small{100'000, before.rlim_max};
	ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
	const Result<size_t> cut = write(at("a"), std::string(1'000'000, 'x'));
	setrlimit(RLIMIT_FSIZE, &before);
	std::signal(SIGXFSZ, handler);
	ASSERT_FALSE(cut);
	EXPECT_NE(cut.error().message.find("too large"), std::string::npos);
	EXPECT_EQ(content(at("a")), "old");
	EXPECT_EQ(entries(), 1);
}

// Sanitizers cause page faults of their own.
#if defined(MADV_POPULATE_READ) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(AtomicFile, AMappedPartThatWasPopulatedIsReadWithoutAFault)
{
	const std::string text(4'000'000, 'x');
	ASSERT_TRUE(write(at("a"), text));
	Result<MappedFile> file = MappedFile::open(at("a"));
	ASSERT_TRUE(file);
	const std::byte* bytes = file.value().bytes();
	const size_t page = size_t(::sysconf(_SC_PAGESIZE));
	if (::madvise(const_cast<std::byte*>(bytes), page, MADV_POPULATE_READ) != 0) GTEST_SKIP() << "this system cannot";
	// The ranges: from the middle of one page to that of another; an empty one; one up to the end, which is inside a page.
	populate(bytes + page + 17, 100 * page);
	populate(bytes + 3, 0);
	populate(bytes + 102 * page + 5, text.size() - (102 * page + 5));
	const auto faults = [] {
		rusage usage;
		getrusage(RUSAGE_THREAD, &usage);
		return usage.ru_minflt;
	};
	const long before = faults();
	size_t same = 0;
	for (size_t i = page; i < text.size(); i += page) same += bytes[i] == std::byte('x');
	EXPECT_LE(faults() - before, 2);
	EXPECT_EQ(same, (text.size() - 1) / page);
}
#endif
#endif  // POSIX
}  // namespace
}  // namespace ist
