// SPDX-License-Identifier: Zlib
// bullethaptics-pack FOLDER NICENESS: carries out the orders of PackingQueue in a folder of trees, one at a time, and ends when there are
// none. It inherits the lock of the folder as file 3.
#include "BulletHapticForce/Preload/PackingOrder.h"
#include "BulletISTCollision/Core/Build/TreeCache.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <utility>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

namespace
{
using namespace preload;
namespace fs = std::filesystem;

/// Paths of all files with an ending, the oldest first.
std::vector<fs::path> filesOf(const fs::path& folder, const char* ending)
{
	std::vector<std::pair<fs::file_time_type, fs::path>> found;
	std::error_code failure;
	for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end; entry.increment(failure))
	{
		std::error_code gone;
		if (entry->path().extension() == ending) found.emplace_back(entry->last_write_time(gone), entry->path());
	}
	std::sort(found.begin(), found.end());
	std::vector<fs::path> result;
	for (auto& [time, path] : found) result.push_back(std::move(path));
	return result;
}

/// The tree goes into the folder. The game learns a failure when it tries itself.
void carryOut(const fs::path& taken, const std::string& key, const fs::path& folder)
{
	const std::optional<PackingOrder> order = PackingOrder::read(taken);
	// An order of another release has another key.
	if (order && order->key() == key) (void)ist::cachedTree(order->mesh, buildOptions(order->spheres), folder.string());
}

void work(const PackingFiles& files)
{
	std::error_code ignored;
	for (const fs::path& left : filesOf(files.folder(), ".taken")) fs::remove(left, ignored);  // by a packer that was ended
	for (std::vector<fs::path> wanted; !(wanted = filesOf(files.folder(), ".wanted")).empty();)
	{
		const std::string key = wanted[0].stem().string();
		std::error_code failure;
		fs::rename(wanted[0], files.taken(key), failure);
		if (!failure) carryOut(files.taken(key), key, files.folder());
		else if (failure != std::errc::no_such_file_or_directory) return;  // it was not withdrawn, so it would be found again and again
		fs::remove(files.taken(key), ignored);
	}
}
}  // namespace

int main(int argc, char** argv)
{
	if (argc != 3)
	{
		std::fputs("bullethaptics-pack: the preload library of BulletHaptics starts this program (docs/from-gimpact.md)\n", stderr);
		return 2;
	}
	close_range(STDERR_FILENO + 2, ~0u, 0);
	if (const pid_t child = fork(); child != 0) return child < 0 ? 1 : 0;
	if (chdir("/") != 0) return 1;
	setpriority(PRIO_PROCESS, 0, std::atoi(argv[2]));
	try
	{
		work(PackingFiles(argv[1]));
	}
	catch (const std::exception&)
	{
		return 1;
	}
	return 0;
}
