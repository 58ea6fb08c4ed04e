// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/AssetFile.h"
#include "BulletISTCollision/Tools/Report.h"

#include <cinttypes>
#include <cstdio>
#include <filesystem>

namespace ist::tools
{
int runInfo(const InfoArguments& a)
{
	const Result<InnerSphereTree> loaded = loadAsset(a.file);
	if (!loaded) return fail(loaded.error().message);
	const InnerSphereTree& tree = loaded.value();
	std::error_code ignored;
	Report report = newReport();
	describeTree(report, tree, std::filesystem::file_size(a.file, ignored));
	report["peak_memory_bytes"] = nullptr;  // of the build: the asset does not keep it
	report["version"] = kAssetVersion;
	char hash[17];
	std::snprintf(hash, sizeof hash, "%016" PRIx64, tree.provenance.meshHash);
	report["mesh_hash"] = hash;
	const double unit = tree.provenance.unit;
	report["unit"] = unit == 1 ? Report("m") : unit == 0.01 ? Report("cm") : unit == 0.001 ? Report("mm") : Report(unit);
	report["nodes"] = tree.law.nodes.size();
	report["center_of_mass"] = toJson(tree.origin);
	Report inertia = Report::array();
	for (const auto& row : tree.inertia.m)
		for (double v : row) inertia.push_back(v);
	report["inertia"] = inertia;
	// The constants of overlapError.
	report["calibration"] = Report{{"splitting_rule", 1}, {"volume_spread", 0.5}, {"force_spread", 0.8}, {"gap", 0.04}};
	std::fputs(format(report, a.json).c_str(), stdout);
	return kGood;
}
}  // namespace ist::tools
