// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Preload/PackingOrder.h"
#include "BulletHapticForce/Preload/PreloadSettings.h"

#include <string>
#include <vector>

namespace preload
{
/// Orders trees from the program `bullethaptics-pack`, which lies beside the library that contains this class. The program works on when
/// the game ends in any way, so that no half of a tree is lost. One packer works in a folder at a time.
class PackingQueue
{
public:
	explicit PackingQueue(const Settings& settings);

	/// Orders the tree of a mesh and returns its key. Returns an empty text when the tree is in the folder already, or when nothing can be
	/// ordered: then the game itself must load or build it.
	std::string order(ist::Mesh mesh);
	/// Withdraws an order that the packer has not taken yet.
	void withdraw(const std::string& key);
	/// Orders among these that are over: their trees are in the folder, or they have failed. Looks only a few times a second.
	/// Starts a packer if none works. If none can be started, all orders are over.
	std::vector<std::string> over(const std::vector<std::string>& keys);

private:
	bool packerWorks();
	void giveUp(const std::string& reason);

	const Settings& m_settings;
	PackingFiles m_files;
	std::filesystem::path m_program;
	bool m_usable = false;
	int m_startsInVain = 0;
	double m_nextLook = 0;  ///< [us], steady
};
}  // namespace preload
