// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshImport.h"

namespace ist
{
Result<Mesh> importMesh(const std::string& path, double, const Progress&)
{
	return Error{"\"" + path + "\" cannot be read: this build has no assimp and reads no mesh files; configure it with BULLETHAPTICS_ASSIMP=ON"};
}
}  // namespace ist
