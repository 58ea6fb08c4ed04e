// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Plugin/PluginFile.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>
#include <type_traits>

#include "BulletISTCollision/Core/Platform/Environment.h"
#include "BulletISTCollision/Core/Platform/InstalledProgram.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "DeviceBridge/Platform/DynamicLibrary.h"

namespace devicebridge
{
namespace
{
const std::string kPrefix = kLibraryPrefix + std::string("devicebridge_"), kSuffix = kLibraryEnding;

bool isName(const std::string& text)
{
	const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
	return !text.empty() && std::all_of(text.begin(), text.end(), plain);
}

std::string fileOf(const std::string& name)
{
	for (const std::string& folder : pluginFolders())
	{
		std::string path = folder + "/" + kPrefix + name + kSuffix;
		std::error_code failure;
		if (std::filesystem::exists(ist::systemPath(path), failure)) return path;
	}
	return {};
}

/// The folder of plug-ins in the installation that this library or program belongs to, wherever it was moved; empty if there is none.
std::string folderOfInstallation()
{
	constexpr int kLevels = 3;  // bin, lib, lib/ARCHITECTURE
	std::filesystem::path folder = ist::fileOfFunction(reinterpret_cast<const void*>(&pluginFolders)).parent_path();
	for (int level = 0; level < kLevels && folder.has_relative_path(); ++level)
	{
		folder = folder.parent_path();
		const std::filesystem::path plugins = folder / DEVICEBRIDGE_LIBRARY_FOLDER / "devicebridge";
		std::error_code failure;
		if (std::filesystem::is_directory(plugins, failure)) return ist::utf8Path(plugins);
	}
	return {};
}

/// What is wrong with the plug-in; empty if it is valid.
std::string flawOf(const devicebridge_plugin* plugin, const std::string& name)
{
	if (!plugin) return "its entry gives nothing";
	if (plugin->version != DEVICEBRIDGE_PLUGIN_VERSION)
		return "it was made for version " + std::to_string(plugin->version) + " of the plug-in interface, this library has " +
			std::to_string(DEVICEBRIDGE_PLUGIN_VERSION);
	if (plugin->size < sizeof(devicebridge_plugin)) return "its table of functions is too short";
	if (!plugin->name || name != plugin->name) return "it calls itself " + std::string(plugin->name ? plugin->name : "nothing");
	if (!plugin->open || !plugin->exchange || !plugin->close) return "it lacks one of open, exchange and close";
	return {};
}
}  // namespace

std::vector<std::string> pluginFolders()
{
	std::vector<std::string> folders;
	std::istringstream parts(ist::environmentValue("DEVICEBRIDGE_PLUGIN_PATH").value_or(""));
	for (std::string folder; std::getline(parts, folder, kFolderSeparator);)
		if (!folder.empty()) folders.push_back(folder);
	if (const std::string folder = folderOfInstallation(); !folder.empty() && folder != DEVICEBRIDGE_PLUGIN_FOLDER)
		folders.push_back(folder);
	folders.push_back(DEVICEBRIDGE_PLUGIN_FOLDER);
	return folders;
}

std::vector<std::string> pluginNames()
{
	std::set<std::string> names;
	for (const std::string& folder : pluginFolders())
	{
		std::error_code failure;
		for (const auto& entry : std::filesystem::directory_iterator(ist::systemPath(folder), failure))
		{
			const std::string file = ist::utf8Path(entry.path().filename());
			if (file.size() <= kPrefix.size() + kSuffix.size() || file.compare(0, kPrefix.size(), kPrefix) != 0) continue;
			if (entry.path().extension() != kSuffix) continue;
			const std::string name = file.substr(kPrefix.size(), file.size() - kPrefix.size() - kSuffix.size());
			if (isName(name)) names.insert(name);
		}
	}
	return {names.begin(), names.end()};
}

ist::Result<const devicebridge_plugin*> loadPlugin(const std::string& name)
{
	if (!isName(name)) return ist::Error{"'" + name + "' cannot be the name of a plug-in: lower-case letters, digits and _ only", false};
	const std::string file = fileOf(name);
	if (file.empty())
	{
		std::string folders;
		for (const std::string& folder : pluginFolders()) folders += (folders.empty() ? "" : ", ") + folder;
		return ist::Error{"No " + kPrefix + name + kSuffix + " in " + folders +
				"; add its folder to DEVICEBRIDGE_PLUGIN_PATH (in a build that is not installed, the folder `plugins` of the build)",
			false};
	}
	DynamicLibrary library;
	if (!library.load(file, DynamicLibrary::Symbols::Own)) return ist::Error{"Cannot load " + file + ": " + library.why(), false};
	const auto entry = library.find<std::remove_pointer_t<devicebridge_plugin_entry_function>>(DEVICEBRIDGE_PLUGIN_ENTRY);
	if (!entry) return ist::Error{file + " is no plug-in: it has no " DEVICEBRIDGE_PLUGIN_ENTRY, false};
	const devicebridge_plugin* const plugin = entry();
	const std::string flaw = flawOf(plugin, name);
	if (!flaw.empty()) return ist::Error{file + " is refused: " + flaw, false};
	return plugin;
}
}  // namespace devicebridge
