// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshFileVertices.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"

namespace ist
{
namespace
{
Error refused(const std::string& path)
{
	return {"\"" + path + "\" cannot be read: this build has no assimp and reads no mesh files; configure it with BULLETHAPTICS_ASSIMP=ON"};
}
}  // namespace

Result<Mesh> importMesh(const std::string& path, std::optional<double>, const Progress&) { return refused(path); }
Result<TexturedMesh> importTexturedMesh(const std::string& path, std::optional<double>, const Progress&) { return refused(path); }
Result<std::vector<Vec3>> importVertices(const std::string& path, std::optional<double>) { return refused(path); }
}  // namespace ist
