// SPDX-License-Identifier: Zlib
// Files that end, block or fill the process that reads them. The reader of most tests is broken_importer.cpp.
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "tests/unit/TestEnvironment.h"

#include <gtest/gtest.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#if !defined(_WIN32)
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#endif

using namespace ist;

namespace
{
constexpr const char* kTooMuchMemory = "reading it takes far more memory than a file of its size needs";

/// Sets a variable of the environment for its lifetime.
class Variable
{
public:
	Variable(const char* name, const std::string& value) : m_name(name) { setenv(name, value.c_str(), 1); }
	~Variable() { unsetenv(m_name); }
	Variable(const Variable&) = delete;
	Variable& operator=(const Variable&) = delete;

private:
	const char* m_name;
};

/// A file in a folder for temporary files, which is removed with the object.
class File
{
public:
	File(const std::string& name, const std::string& text)
		: m_path((std::filesystem::path(::testing::TempDir()) / (std::to_string(getpid()) + "_" + name)).string())
	{
		std::ofstream(m_path) << text;
	}
	~File() { std::filesystem::remove(m_path); }
	File(const File&) = delete;
	File& operator=(const File&) = delete;
	const std::string& path() const { return m_path; }
	/// What importMesh() says about it.
	std::string refusal() const
	{
		const Result<Mesh> mesh = importMesh(m_path);
		return mesh ? "read" : mesh.error().message;
	}

private:
	std::string m_path;
};

std::string refusalOf(const std::string& behaviour)
{
	const Variable broken("BULLETHAPTICS_IMPORT", BROKEN_IMPORTER);
	return File("body.x3d", behaviour).refusal();
}

/// Whether this process has no children, running or ended. Windows keeps no list of them.
bool hasNoChild()
{
#if defined(_WIN32)
	return true;
#else
	return ::waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD;
#endif
}
}  // namespace

TEST(ImportApart, AProcessThatBreaksDownIsARefusal)
{
	ASSERT_EQ(refusalOf("box"), "read");
	for (const char* behaviour : {"abort", "segment", "exit"})
	{
		const std::string refusal = refusalOf(behaviour);
		EXPECT_NE(refusal.find("body.x3d: the reader of .x3d files broke down on it, so it is damaged; export it again"), std::string::npos)
			<< behaviour << ": " << refusal;
		EXPECT_TRUE(hasNoChild());
	}
}

TEST(ImportApart, AGroupThatAssimpLeavesEmptyIsSaid)
{
	// The line that begins with a full stop opens a group for which the reader of RAW files in assimp 5.2.5 leaves a null pointer.
	const File file("body.raw", "0 0 0 0 1 0 1 0 0\n. 0 0 1 0 0 0 0 1\n0 0 0 0 0 1 0 1 0\n1 0 0 0.1 0 0 0 1\n");
	const Result<Mesh> mesh = importMesh(file.path());
	ASSERT_TRUE(mesh) << mesh.error().message;
	ASSERT_EQ(mesh.value().notTaken.size(), 1u);
	EXPECT_EQ(mesh.value().notTaken[0].find("Parts of the file in which the reader found no triangle: 1"), 0u) << mesh.value().notTaken[0];
	EXPECT_TRUE(hasNoChild());
}

TEST(ImportApart, AnEndlessLoopIsARefusal)
{
	const Variable seconds("BULLETHAPTICS_IMPORT_SECONDS", "1");
	const std::string refusal = refusalOf("loop");
	EXPECT_NE(refusal.find("reading it takes too long"), std::string::npos) << refusal;
	EXPECT_NE(refusal.find("BULLETHAPTICS_IMPORT_SECONDS"), std::string::npos) << refusal;
}

#ifndef BULLETHAPTICS_SANITIZED
TEST(ImportApart, AFileThatTakesAllMemoryIsARefusal)
{
	const std::string refusal = refusalOf("memory");
	EXPECT_NE(refusal.find(kTooMuchMemory), std::string::npos) << refusal;
}

// Memory is 1 GB and 1000 times the size of the file.
TEST(ImportApart, MemoryIsLimitedByTheSizeOfTheFile)
{
	EXPECT_EQ(refusalOf("use 900 0"), "read");
	const std::string refusal = refusalOf("use 1100 0");
	EXPECT_NE(refusal.find(kTooMuchMemory), std::string::npos) << refusal;
	EXPECT_NE(refusal.find("BULLETHAPTICS_IMPORT_MEGABYTES"), std::string::npos) << refusal;
	EXPECT_EQ(refusalOf("use 1100 0" + std::string(300000, ' ')), "read");
	EXPECT_EQ(refusalOf("use 1100 300000"), "read") << "a file beside it counts, too";
	const Variable megabytes("BULLETHAPTICS_IMPORT_MEGABYTES", "1300");
	EXPECT_EQ(refusalOf("use 1100 0"), "read");
}

TEST(ImportApart, AFileThatStatesFarMoreVerticesThanItHasIsARefusal)
{
	// The reader of OFF files in assimp 5.2.5 allocates what the first line states: 400 million vertices, 4.8 GB.
	const File file("body.off", "OFF\n400000000 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
	const std::string refusal = file.refusal();
	EXPECT_NE(refusal.find(kTooMuchMemory), std::string::npos) << refusal;
}

TEST(ImportApart, TheFileOfNumbersBesideAGltfFileCounts)
{
	// Its reader takes the whole file, here more than a gigabyte that is zero but for a triangle.
	const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
	constexpr std::uintmax_t kSize = 1100000000;
	const File numbers("body.bin", std::string(reinterpret_cast<const char*>(corners), sizeof corners));
	std::filesystem::resize_file(numbers.path(), kSize);
	const File file("body.gltf",
		R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"buffers":[{"byteLength":)" +
			std::to_string(kSize) + R"(,"uri":")" + std::filesystem::path(numbers.path()).filename().string() +
			R"("}],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
			R"("min":[0,0,0],"max":[1,1,0]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})");
	EXPECT_EQ(file.refusal(), "read");
}
#endif

TEST(ImportApart, AnswersThatCannotBeRightAreRefused)
{
	for (const char* behaviour : {"huge_sentence", "huge_mesh", "cut", "unknown", "corners"})
	{
		const std::string refusal = refusalOf(behaviour);
		EXPECT_NE(refusal.find("broke down"), std::string::npos) << behaviour << ": " << refusal;
	}
}

TEST(ImportApart, CancellingEndsTheProcess)
{
	const Variable broken("BULLETHAPTICS_IMPORT", BROKEN_IMPORTER);
	const File file("body.x3d", "sleep");
	int calls = 0;
	const Result<Mesh> mesh = importMesh(file.path(), 1, [&](const char*, double) { return ++calls < 3; });
	ASSERT_FALSE(mesh);
	EXPECT_TRUE(mesh.error().cancelled);
	EXPECT_TRUE(hasNoChild());
}

TEST(ImportApart, OwnReadersNeedNoProgram)
{
	const Variable given("BULLETHAPTICS_IMPORT", "/nowhere/bullethaptics-import");
	const File stl(
		"body.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n");
	EXPECT_EQ(stl.refusal(), "read");
}

TEST(ImportApart, AProgramThatIsNotThereIsNamed)
{
	const File file("body.x3d", "box"), noProgram("no_program", "");
	for (const std::string& program : {std::string("/nowhere/bullethaptics-import"), noProgram.path()})
	{
		const Variable given("BULLETHAPTICS_IMPORT", program);
		const std::string refusal = file.refusal();
		EXPECT_NE(refusal.find(".x3d files are read by the program bullethaptics-import"), std::string::npos) << refusal;
		EXPECT_NE(refusal.find(program), std::string::npos) << refusal;
		EXPECT_NE(refusal.find("set BULLETHAPTICS_IMPORT to its path"), std::string::npos) << refusal;
	}
}

// Signals, scripts and file descriptors are those of POSIX.
#if !defined(_WIN32)
TEST(ImportApart, TheProgramOfAnotherReleaseIsNamed)
{
	const File file("body.x3d", "box"), other("other_release", "#!/bin/sh\nexit 2\n");
	::chmod(other.path().c_str(), 0700);
	const Variable given("BULLETHAPTICS_IMPORT", other.path());
	const std::string refusal = file.refusal();
	EXPECT_NE(refusal.find("but " + other.path() + " is not that of release"), std::string::npos) << refusal;
	EXPECT_NE(refusal.find("set BULLETHAPTICS_IMPORT to its path"), std::string::npos) << refusal;
}

TEST(ImportApart, WorksInProgramsThatWaitForTheirChildrenElsewhere)
{
	const auto before = std::signal(SIGCHLD, SIG_IGN);
	const std::string read = refusalOf("box"), refused = refusalOf("abort");
	std::signal(SIGCHLD, before);
	EXPECT_EQ(read, "read");
	EXPECT_NE(refused.find("broke down"), std::string::npos) << refused;
}

TEST(ImportApart, WorksInProgramsThatClosedTheirStandardStreams)
{
	std::array<int, 3> kept{};
	for (int stream = 0; stream < 3; ++stream)
	{
		kept[size_t(stream)] = ::fcntl(stream, F_DUPFD_CLOEXEC, 10);  // a lower one may be that of a stream that was closed
		::close(stream);
	}
	const std::string read = refusalOf("box");
	for (int stream = 0; stream < 3; ++stream)
	{
		::dup2(kept[size_t(stream)], stream);
		::close(kept[size_t(stream)]);
	}
	EXPECT_EQ(read, "read");
}

TEST(ImportApart, LeavesTheFilesOfTheProgramAlone)
{
	// Otherwise a device or socket that the program closes would stay open as long as a file is read.
	int ends[2];
	ASSERT_EQ(::pipe(ends), 0);
	const File file("body.x3d", "sleep");
	const Variable broken("BULLETHAPTICS_IMPORT", BROKEN_IMPORTER);
	bool ended = false;
	const Result<Mesh> mesh = importMesh(file.path(), 1, [&, calls = 0](const char*, double) mutable {
		if (++calls < 4) return true;
		::close(ends[1]);
		char byte = 0;
		ended = ::read(ends[0], &byte, 1) == 0;
		return false;
	});
	::close(ends[0]);
	EXPECT_FALSE(mesh);
	EXPECT_TRUE(ended);
}
#endif
