// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ist
{
/// A transform of a 3MF file: a point of the object goes to linear * point + offset. It may scale, shear and mirror.
struct PackageTransform
{
	Mat3 linear;
	Vec3 offset;
};

/// An object that is placed: by an item of the build, or as a component of another object.
struct PackageInstance
{
	std::string part;  ///< the model part that has the object, as it stands in the file; empty for the part of the instance itself
	std::string object;
	PackageTransform transform;
};

/// An object has triangles, or is composed of other objects. Lengths are in units of the file.
struct PackageObject
{
	std::vector<Vec3> vertices;
	/// Corners as the file has them: they need not exist.
	std::vector<std::array<uint32_t, 3>> triangles;
	/// For each triangle, or empty if none has texture coordinates; NaN for a triangle without.
	std::vector<std::array<TexturePlace, 3>> places;
	std::vector<PackageInstance> components;
};

/// One model part of a 3MF package.
struct PackageModel
{
	std::optional<std::string> unit;               ///< as the part states it
	std::map<std::string, PackageObject> objects;  ///< by their id; of two with one id the first
	std::vector<PackageInstance> build;
};

/// Reads a model part (3MF core specification 1.3, and the production and materials extensions): triangle meshes, components, items of
/// the build and texture coordinates. Other elements are skipped. `progress` gets the share of the text that was read and may cancel.
/// Errors are the ends of sentences that begin with the path: text that is no whole XML, and numbers that are missing or none.
Result<PackageModel> readPackageModel(std::string_view text, const std::function<bool(double)>& progress = {});
}  // namespace ist
