// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/ImportApart.h"

#include "BulletISTCollision/Core/Import/MeshImport.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace ist::tools
{
namespace
{
/// Share of the machine's memory that reading a file may take.
constexpr double kMemoryShare = 0.75;
/// Longest time until a cancellation takes effect.
constexpr int kPollMilliseconds = 100;

/// Type of the next bytes in the pipe.
enum class Part : char
{
	Fraction,
	Failure,
	Surface
};

/// One end of a pipe. Functions return false if the other end is closed.
class PipeEnd
{
public:
	explicit PipeEnd(int file) : m_file(file) {}
	~PipeEnd() { ::close(m_file); }
	PipeEnd(const PipeEnd&) = delete;
	PipeEnd& operator=(const PipeEnd&) = delete;

	bool send(const void* data, size_t size)
	{
		return transfer(size, [&](size_t done) { return ::write(m_file, static_cast<const char*>(data) + done, size - done); });
	}
	bool receive(void* data, size_t size)
	{
		return transfer(size, [&](size_t done) { return ::read(m_file, static_cast<char*>(data) + done, size - done); });
	}
	template <class T> bool send(const T& value) { return send(&value, sizeof value); }
	template <class T> bool receive(T& value) { return receive(&value, sizeof value); }
	template <class Array> bool sendArray(const Array& array)
	{
		return send(array.size()) && send(array.data(), array.size() * sizeof array[0]);
	}
	template <class Array> bool receiveArray(Array& array)
	{
		size_t size = 0;
		if (!receive(size)) return false;
		array.resize(size);
		return receive(array.data(), size * sizeof array[0]);
	}
	bool sendTexts(const std::vector<std::string>& texts)
	{
		return send(texts.size()) && std::ranges::all_of(texts, [&](const std::string& text) { return sendArray(text); });
	}
	bool receiveTexts(std::vector<std::string>& texts)
	{
		size_t count = 0;
		if (!receive(count)) return false;
		texts.resize(count);
		return std::ranges::all_of(texts, [&](std::string& text) { return receiveArray(text); });
	}
	/// Whether the next receive will not block, because data has arrived or the other end is closed.
	bool waits() const
	{
		pollfd asked{m_file, POLLIN, 0};
		return ::poll(&asked, 1, kPollMilliseconds) > 0;
	}

private:
	template <class Call> static bool transfer(size_t size, const Call& call)
	{
		for (size_t done = 0; done < size;)
		{
			const ssize_t n = call(done);
			if (n > 0) done += static_cast<size_t>(n);
			else if (n == 0 || errno != EINTR) return false;
		}
		return true;
	}

	int m_file;
};

Error tooLarge(const std::string& path)
{
	return {path + ": reading it takes more memory than this machine has to spare; it is damaged, or too large: export it again"};
}

/// Confines this process, so that a file that takes all memory or crashes it ends only this process, without any output.
void confine()
{
	std::signal(SIGINT, SIG_DFL);
	std::signal(SIGTERM, SIG_DFL);
	const rlimit none{0, 0};
	setrlimit(RLIMIT_CORE, &none);
// Not with sanitizers: they map terabytes, and their output must be visible.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
	rlimit memory{};
	getrlimit(RLIMIT_AS, &memory);
	const auto share = static_cast<rlim_t>(
		kMemoryShare * static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE)));
	memory.rlim_cur = std::min(memory.rlim_cur, share);
	setrlimit(RLIMIT_AS, &memory);
	if (const int nowhere = ::open("/dev/null", O_WRONLY); nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
#endif
}

bool importAndSend(const std::string& path, std::optional<double> unit, PipeEnd& pipe) noexcept
{
	confine();
	Result<Mesh> mesh = importMesh(
		path, unit, [&](const char*, double fraction) { return pipe.send(Part::Fraction) && pipe.send(fraction); });
	if (!mesh)
	{
		const bool forMemory = mesh.error().message.find("bad_alloc") != std::string::npos;
		return pipe.send(Part::Failure) && pipe.sendArray(forMemory ? tooLarge(path).message : mesh.error().message);
	}
	const auto& [vertices, triangles, rounding, notTaken, applied] = mesh.value();
	return pipe.send(Part::Surface) && pipe.sendArray(vertices) && pipe.sendArray(triangles) && pipe.send(rounding) &&
		pipe.sendTexts(notTaken) && pipe.send(applied);
}

/// Empty if the other process ended without an answer.
std::optional<Result<Mesh>> receiveAnswer(PipeEnd& pipe, const Progress& progress)
{
	double fraction = 0;
	for (;;)
	{
		if (progress && !progress("import", fraction)) return Error{"the import was cancelled", true};
		if (!pipe.waits()) continue;
		Part part{};
		if (!pipe.receive(part)) return std::nullopt;
		if (part == Part::Fraction)
		{
			if (!pipe.receive(fraction)) return std::nullopt;
			continue;
		}
		if (part == Part::Failure)
		{
			Error error;
			if (!pipe.receiveArray(error.message)) return std::nullopt;
			return error;
		}
		Mesh mesh;
		if (!pipe.receiveArray(mesh.vertices) || !pipe.receiveArray(mesh.triangles) || !pipe.receive(mesh.rounding) ||
			!pipe.receiveTexts(mesh.notTaken) || !pipe.receive(mesh.unit))
			return std::nullopt;
		return mesh;
	}
}

Error brokeDown(const std::string& path, int status)
{
	const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
	if (signal == SIGINT || signal == SIGTERM) return {"the import was cancelled", true};
	if (signal == SIGKILL) return tooLarge(path);
	return {path + ": the reader of " + std::filesystem::path(path).extension().string() +
		" files broke down on it, so it is damaged; export it again"};
}
}  // namespace

Result<Mesh> importApart(const std::string& path, std::optional<double> unit, const Progress& progress)
{
	int ends[2];
	if (::pipe(ends) != 0) return importMesh(path, unit, progress);
#ifdef F_SETPIPE_SZ
	(void)::fcntl(ends[1], F_SETPIPE_SZ, 1 << 20);
#endif
	std::optional<PipeEnd> in(ends[0]), out(ends[1]);
	const pid_t reader = ::fork();
	if (reader < 0) return importMesh(path, unit, progress);
	if (reader == 0)
	{
		in.reset();
		::_exit(importAndSend(path, unit, *out) ? 0 : 1);
	}
	out.reset();
	std::optional<Result<Mesh>> answer = receiveAnswer(*in, progress);
	if (answer) ::kill(reader, SIGKILL);
	int status = 0;
	while (::waitpid(reader, &status, 0) < 0 && errno == EINTR)
	{}
	if (!answer) return brokeDown(path, status);
	return *std::move(answer);
}
}  // namespace ist::tools
