// SPDX-License-Identifier: Zlib
// STL files: any bytes are refused with a reason, or give triangles whose corners exist.
#include "BulletISTCollision/Core/Import/Formats/StlFile.h"

#include "tests/fuzz/Invariants.h"

#include <string_view>

using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const std::string_view bytes(reinterpret_cast<const char*>(data), size);
	const ist::Result<ist::Mesh> mesh = ist::readStl(bytes);
	if (!fuzz::accepted(mesh)) return 0;
	require(mesh.value().vertices.size() >= 3 * mesh.value().triangles.size(), "each triangle has corners of its own");
	require(mesh.value().triangles.size() <= size / 8, "triangles do not come from nowhere");
	for (const auto& triangle : mesh.value().triangles)
		for (const std::uint32_t corner : triangle) require(corner < mesh.value().vertices.size(), "corners of triangles are there");
	for (const std::string& sentence : mesh.value().notTaken)
		require(sentence.size() > 10 && sentence.back() == '.', "sentences are whole");
	return 0;
}
