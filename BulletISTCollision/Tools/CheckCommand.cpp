// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "BulletISTCollision/Tools/AssetCheck.h"
#include "BulletISTCollision/Tools/Report.h"

#include <cstdio>
#include <optional>

namespace ist::tools
{
namespace
{
/// Turns the mesh as `--up` turned it when the tree was built, which the asset does not record. False if no turn gives that mesh.
bool turnAsRecorded(Mesh& mesh, uint64_t hash)
{
	for (int from = 0; from < 6; ++from)
		for (int to = 0; to < 6; ++to)
			if (Mesh turned = turnedUp(mesh, {from / 2, from % 2 ? -1 : 1}, {to / 2, to % 2 ? -1 : 1}); meshHash(turned) == hash)
			{
				mesh = std::move(turned);
				return true;
			}
	return false;
}

/// The mesh in the unit that the asset records. Releases before 0.2 recorded metres if they were built without a unit, even for files
/// that state another one. COLLADA files were imported in the stated unit all the same.
Result<Mesh> recordedMesh(const InnerSphereTree& tree, const std::string& path)
{
	Result<Mesh> mesh = importMesh(path, tree.provenance.unit);
	if (!mesh || turnAsRecorded(mesh.value(), tree.provenance.meshHash)) return mesh;
	Result<Mesh> asStated = importMesh(path, std::nullopt);
	return asStated && turnAsRecorded(asStated.value(), tree.provenance.meshHash) ? asStated : mesh;
}

/// The surface that was packed: the mesh after the recorded repair, in the tree frame.
Result<Mesh> packedSurface(const InnerSphereTree& tree, const std::string& path, std::vector<std::string>& problems)
{
	const Result<Mesh> mesh = recordedMesh(tree, path);
	if (!mesh) return mesh.error();
	warnOfNotTaken(path, mesh.value());
	if (meshHash(mesh.value()) != tree.provenance.meshHash) problems.push_back("the mesh is not the one that the asset was built from");
	const RepairChoice choice = repairChoice(tree.provenance.repairMode).value_or(RepairChoice());
	const Result<RepairedMesh> repaired = repair(mesh.value(), choice.mode, {}, 1, choice.ground);
	if (!repaired) return Error{path + ": " + repaired.error().message};
	return translated(repaired.value().mesh, -tree.origin);
}

std::string count(int64_t n, const char* what) { return std::to_string(n) + " " + what; }
}  // namespace

int runCheck(const CheckArguments& a)
{
	Report report = newReport();
	std::vector<std::string> problems;
	const Result<InnerSphereTree> tree = loadTree(a.file);
	report["ok"] = false;
	for (const char* name : {"spheres", "overlapping_pairs", "max_overlap", "protruding", "max_protrusion", "surface_elements",
			 "surface_area_error", "surface_open_area"})
		report[name] = nullptr;
	if (!tree) problems.push_back(tree.error().message);
	else
	{
		const std::span<const Sphere> spheres = tree.value().spheres;
		const OverlapFinding overlaps = findOverlaps(spheres);
		report["spheres"] = spheres.size();
		report["overlapping_pairs"] = overlaps.pairs;
		report["max_overlap"] = overlaps.deepest;
		if (overlaps.pairs > 0) problems.push_back(count(overlaps.pairs, "pairs of spheres overlap"));
		report["surface_elements"] = tree.value().surface.surface.elements.size();
		if (!tree.value().surface.empty())
		{
			const SurfaceFinding surface = checkSurface(tree.value());
			report["surface_area_error"] = surface.areaError;
			report["surface_open_area"] = surface.openArea;
			if (!surface.holds()) problems.push_back("the surface is not closed, or has another area than the mesh");
		}
		if (!a.mesh.empty())
		{
			const Result<Mesh> surface = packedSurface(tree.value(), a.mesh, problems);
			if (!surface) return fail(surface.error().message, surface.error().cancelled ? kInterrupted : kBadInput);
			const ProtrusionFinding protrusions = findProtrusions(spheres, surface.value());
			report["protruding"] = protrusions.spheres;
			report["max_protrusion"] = protrusions.farthest;
			if (protrusions.spheres > 0) problems.push_back(count(protrusions.spheres, "spheres protrude from the mesh"));
		}
	}
	report["ok"] = problems.empty();
	report["problems"] = problems;
	std::fputs(format(report, a.json).c_str(), stdout);
	for (const std::string& problem : problems) fail(problem);
	return problems.empty() ? kGood : kBadInput;
}
}  // namespace ist::tools
