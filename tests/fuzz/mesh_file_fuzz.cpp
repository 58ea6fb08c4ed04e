// SPDX-License-Identifier: Zlib
// OBJ files: any bytes are refused, or give triangles whose corners exist and are finite. In between runs assimp, which is as robust as its
// release; it runs in this process, as in that of the importer program.
#include "BulletISTCollision/Importer/AssimpImport.h"

#include "tests/fuzz/Invariants.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

using fuzz::require;

namespace
{
/// A folder of this process alone, which is removed with the object.
struct Folder
{
	std::filesystem::path path;
	Folder()
	{
		std::string name = (std::filesystem::temp_directory_path() / "fuzz_mesh_file.XXXXXX").string();
		require(mkdtemp(name.data()), "a folder for the file");
		path = name;
	}
	~Folder()
	{
		std::error_code ignored;
		std::filesystem::remove_all(path, ignored);
	}
};
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	static const Folder folder;
	if (size == 0) return 0;
	const std::string path = folder.path / "mesh.obj";
	std::FILE* file = std::fopen(path.c_str(), "wb");
	require(file && std::fwrite(data, 1, size, file) == size, "the file is written");
	std::fclose(file);
	const ist::Result<ist::TexturedMesh> surface = ist::importByAssimp(path, {}, ist::Wanted::Surface, {}),
										 textured = ist::importByAssimp(path, {}, ist::Wanted::SurfaceAndPlaces, {});
	const ist::Result<ist::Mesh> mesh = surface ? ist::Result<ist::Mesh>(surface.value().mesh) : surface.error();
	std::filesystem::remove(path);
	if (fuzz::accepted(textured))
	{
		require(mesh && textured.value().mesh.triangles == mesh.value().triangles &&
				textured.value().places.size() == mesh.value().triangles.size(),
			"the same triangles, each with its places");
		for (const auto& corners : textured.value().places)
			for (const ist::TexturePlace& place : corners)
				require(std::isfinite(place.u) && std::isfinite(place.v), "places in the picture are finite");
	}
	if (!fuzz::accepted(mesh)) return 0;
	require(!mesh.value().triangles.empty(), "there are triangles");
	for (const ist::Vec3& p : mesh.value().vertices) require(ist::isFinite(p), "corners are finite");
	for (const auto& triangle : mesh.value().triangles)
		for (const std::uint32_t corner : triangle) require(corner < mesh.value().vertices.size(), "corners of triangles are there");
	return 0;
}
