// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeBuilder.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

namespace preload
{
/// Options of the trees of a preloaded program. The game and the packer must agree on them.
ist::BuildOptions buildOptions(int spheres);

/// Files in the folder of the trees through which games order trees and the packer delivers them:
/// KEY.wanted   an order: the mesh and its options
/// KEY.taken    an order that the packer carries out
/// KEY.ist      the tree (ist::cachedTree)
/// packer.lock  locked while a packer works in this folder
/// KEY is the tree's ist::treeKey.
class PackingFiles
{
public:
	explicit PackingFiles(std::filesystem::path folder) : m_folder(std::move(folder)) {}

	std::filesystem::path wanted(const std::string& key) const { return m_folder / (key + ".wanted"); }
	std::filesystem::path taken(const std::string& key) const { return m_folder / (key + ".taken"); }
	std::filesystem::path tree(const std::string& key) const { return m_folder / (key + ".ist"); }
	std::filesystem::path lock() const { return m_folder / "packer.lock"; }
	const std::filesystem::path& folder() const { return m_folder; }

private:
	std::filesystem::path m_folder;
};

struct PackingOrder
{
	ist::Mesh mesh;
	int spheres = 0;

	std::string key() const;
	/// Writes the file under another name first, so that nobody reads half of it. Returns false when it cannot be written.
	bool write(const std::filesystem::path& path) const;
	/// Nothing when the file cannot be read or is incomplete.
	static std::optional<PackingOrder> read(const std::filesystem::path& path);
};
}  // namespace preload
