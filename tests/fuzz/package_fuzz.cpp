// SPDX-License-Identifier: Zlib
// 3MF files: any bytes, and any text of a model in a package that is whole, are refused with a reason, or give triangles whose corners
// exist.
#include "BulletISTCollision/Core/Import/Formats/PackageFile.h"

#include "tests/fuzz/Invariants.h"
#include "tests/unit/Core/Import/PackageText.h"

#include <string_view>

using fuzz::require;

namespace
{
void checkPackage(std::string_view bytes)
{
	const ist::Result<ist::PackageSurface> surface = ist::readPackage(bytes);
	if (!fuzz::accepted(surface)) return;
	const ist::Mesh& mesh = surface.value().textured.mesh;
	require(surface.value().textured.places.empty() || surface.value().textured.places.size() == mesh.triangles.size(),
		"each triangle has texture coordinates, or none has");
	for (const auto& triangle : mesh.triangles)
		for (const std::uint32_t corner : triangle) require(corner < mesh.vertices.size(), "corners of triangles are there");
	for (const std::string& sentence : mesh.notTaken) require(sentence.size() > 10 && sentence.back() == '.', "sentences are whole");
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const std::string text(reinterpret_cast<const char*>(data), size);
	checkPackage(text);
	checkPackage(packageText(text, {{"3D/b.model", text}}));
	return 0;
}
