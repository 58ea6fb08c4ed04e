// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/ImportPipe.h"

#include <algorithm>

namespace ist
{
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
		if (!m_end.receive(array.data() + done, more * sizeof array[0])) return false;
	}
	return true;
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
