// SPDX-License-Identifier: Zlib
// bullethaptics-import with a reader that does what the first word of the file says, as damaged files make assimp do.
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Platform/PipeEnd.h"
#include "BulletISTCollision/Importer/Importer.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace ist;

namespace
{
/// Writes the numbers as they lie in memory to the pipe, and ends the process.
template <class... Numbers> [[noreturn]] void answerBy(Numbers... numbers)
{
	std::string bytes;
	const auto append = [&](const auto& number) { bytes.append(reinterpret_cast<const char*>(&number), sizeof number); };
	(append(numbers), ...);
	PipeEnd output;
	output.useStandardOutput();
	std::_Exit(output.send(bytes.data(), bytes.size()) ? 0 : 1);
}

/// Allocates as many megabytes for a moment. Throws std::bad_alloc if they are too many.
void allocate(double megabytes)
{
	std::vector<std::unique_ptr<char[]>> all;
	for (double i = 0; i < megabytes; ++i) all.emplace_back(new char[1000000]);
#ifdef _WIN32
	// Under Wine no system limits the memory, but a thread that looks ten times a second how much of it was written to.
	for (const std::unique_ptr<char[]>& one : all) std::memset(one.get(), 1, 1000000);
	std::this_thread::sleep_for(std::chrono::milliseconds(300));
#endif
}

Result<TexturedMesh> misread(const std::string& path, std::optional<double>, Wanted, const Progress&, const FileOpened& opened)
{
	std::string word;
	std::ifstream text(path);
	text >> word;
	double megabytes = 0, bytesBeside = 0;
	if (word == "use" && text >> megabytes >> bytesBeside)
	{
		opened(bytesBeside);
		allocate(megabytes);
	}
	if (word == "abort") std::abort();
	if (word == "segment") std::raise(SIGSEGV);
	if (word == "exit") std::exit(0);
	if (word == "loop")
		for (std::atomic<int> i = 0;; ++i)
		{}
	if (word == "sleep") std::this_thread::sleep_for(std::chrono::minutes(10));
	if (word == "memory")
		for (std::vector<std::unique_ptr<char[]>> all;;) all.emplace_back(new char[std::size_t(1) << 28]);
	constexpr char kFailure = 1, kSurface = 2, kUnknown = 7;
	constexpr std::size_t kHuge = std::size_t(1) << 60, kNone = 0;
	if (word == "huge_sentence") answerBy(kFailure, kHuge, 'x');
	if (word == "huge_mesh") answerBy(kSurface, kHuge, 1.0, 2.0, 3.0);
	if (word == "cut") answerBy(kSurface, kNone);
	if (word == "unknown") answerBy(kUnknown);
	TexturedMesh textured{makeBoxMesh({1, 1, 1}), {}};
	if (word == "corners") textured.mesh.triangles[3][1] = 8;
	return textured;
}
}  // namespace

int main(int argc, char** argv) { return runImporter(argc, argv, misread); }
