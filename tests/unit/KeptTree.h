// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <utility>

/// The tree of a mesh, with levels, stored in the build folder. Building it takes seconds, and every test is a separate process.
inline std::shared_ptr<const ist::InnerSphereTree> keptTree(const ist::Mesh& mesh, const char* name, int spheres = 300)
{
	const std::filesystem::path file = std::filesystem::path(TREE_FOLDER) / name;
	ist::Result<ist::InnerSphereTree> tree = ist::loadAsset(file.string());
	if (!tree)
	{
		ist::BuildOptions options;
		options.maxSpheres = spheres;
		tree = ist::buildTree(mesh, options);
		const std::string unique = file.string() + std::to_string(std::random_device()());
		if (ist::saveAsset(tree.value(), unique)) std::filesystem::rename(unique, file);
	}
	if (tree.value().levels.empty()) tree.value().levels = ist::buildLevels(tree.value().law);
	return std::make_shared<const ist::InnerSphereTree>(std::move(tree).value());
}
