// SPDX-License-Identifier: Zlib
// PLY files: any bytes are refused with a reason, or give triangles whose corners exist.
#include "BulletISTCollision/Core/Import/Formats/PlyFile.h"

#include "tests/fuzz/Invariants.h"

#include <string_view>

using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const std::string_view bytes(reinterpret_cast<const char*>(data), size);
	const ist::Result<ist::PlySurface> surface = ist::readPly(bytes);
	if (!fuzz::accepted(surface)) return 0;
	const ist::Mesh& mesh = surface.value().textured.mesh;
	require(mesh.vertices.size() <= size && mesh.triangles.size() <= size, "vertices and triangles do not come from nowhere");
	require(surface.value().textured.places.empty() || surface.value().textured.places.size() == mesh.triangles.size(),
		"each triangle has texture coordinates, or none has");
	for (const auto& triangle : mesh.triangles)
		for (const std::uint32_t corner : triangle) require(corner < mesh.vertices.size(), "corners of triangles are there");
	for (const std::string& sentence : mesh.notTaken) require(sentence.size() > 10 && sentence.back() == '.', "sentences are whole");
	return 0;
}
