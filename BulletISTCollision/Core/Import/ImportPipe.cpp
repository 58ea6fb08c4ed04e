// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/ImportPipe.h"

#include <algorithm>
#include <cerrno>
#include <utility>

#include <poll.h>
#include <unistd.h>

namespace ist
{
namespace
{
/// Calls until all bytes are through. Both read() and write() return 0 or less when no more will come.
template <class Call> bool transfer(std::size_t size, const Call& call)
{
	for (std::size_t done = 0; done < size;)
	{
		const ssize_t n = call(done);
		if (n > 0) done += static_cast<std::size_t>(n);
		else if (n == 0 || errno != EINTR) return false;
	}
	return true;
}
}  // namespace

void ImportPipe::close()
{
	if (m_file >= 0) ::close(std::exchange(m_file, -1));
}

bool ImportPipe::sendBytes(const void* data, std::size_t size)
{
	return transfer(size, [&](std::size_t done) { return ::write(m_file, static_cast<const char*>(data) + done, size - done); });
}

bool ImportPipe::receiveBytes(void* data, std::size_t size)
{
	return transfer(size, [&](std::size_t done) { return ::read(m_file, static_cast<char*>(data) + done, size - done); });
}

template <class Array> bool ImportPipe::receiveArray(Array& array)
{
	constexpr std::size_t kBlock = (std::size_t(1) << 24) / sizeof array[0];
	array.clear();
	std::size_t size = 0;
	if (!receive(size)) return false;
	while (array.size() < size)
	{
		const std::size_t done = array.size(), more = std::min(kBlock, size - done);
		array.resize(done + more);
		if (!receiveBytes(array.data() + done, more * sizeof array[0])) return false;
	}
	return true;
}

bool ImportPipe::waits(int milliseconds) const
{
	pollfd asked{m_file, POLLIN, 0};
	return ::poll(&asked, 1, milliseconds) > 0;
}

bool ImportPipe::sendSurface(const TexturedMesh& textured)
{
	const auto& [vertices, triangles, rounding, notTaken, unit] = textured.mesh;
	if (!send(Part::Surface) || !sendArray(vertices) || !sendArray(triangles) || !sendArray(textured.places) || !send(rounding) ||
		!send(unit) || !send(notTaken.size()))
		return false;
	return std::all_of(notTaken.begin(), notTaken.end(), [&](const std::string& sentence) { return sendArray(sentence); });
}

bool ImportPipe::receiveSurface(TexturedMesh& textured)
{
	Mesh& mesh = textured.mesh;
	std::size_t sentences = 0;
	if (!receiveArray(mesh.vertices) || !receiveArray(mesh.triangles) || !receiveArray(textured.places) || !receive(mesh.rounding) ||
		!receive(mesh.unit) || !receive(sentences))
		return false;
	mesh.notTaken.clear();
	while (mesh.notTaken.size() < sentences)
		if (!receiveArray(mesh.notTaken.emplace_back())) return false;
	const auto isThere = [&](const auto& triangle) {
		return std::all_of(triangle.begin(), triangle.end(), [&](uint32_t corner) { return corner < mesh.vertices.size(); });
	};
	return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), isThere) &&
		(textured.places.empty() || textured.places.size() == mesh.triangles.size());
}

template bool ImportPipe::receiveArray(std::string&);
}  // namespace ist
