// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Report.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Mesh/LengthUnit.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Core/Repair/MeshGround.h"
#include "BulletISTCollision/Json/ReadableText.h"
#include "BulletISTCollision/Tools/Commands.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string_view>
#include <utility>

namespace ist::tools
{
std::string withFlags(std::string sentence)
{
	static constexpr std::pair<std::string_view, std::string_view> kFlags[] = {
		{"call buildTree() with BuildOptions::maxSpheres instead", "give --spheres without --error"},
		{"pass its unit to importMesh()", "give its unit (--unit)"}, {"RepairMode::Wrap", "--repair wrap"},
		{"RepairMode::Ground", "--repair ground DEPTH, in metres; up is y, or what --up says"},
		{"name that axis as up", "name as up (--up) the axis of the file that became it; without --up that is the same axis"},
		{"BuildOptions::maxSpheres", "--spheres"}, {"BuildOptions::targetFill", "--fill"}, {"BuildOptions::minRadius", "--min-radius"}};
	for (const auto& [setting, flag] : kFlags)
		for (size_t at = 0; (at = sentence.find(setting, at)) != sentence.npos; at += flag.size())
			sentence.replace(at, setting.size(), flag);
	return sentence;
}

Report newReport()
{
	Report report;
	report["schema"] = 1;
	return report;
}

Report toJson(const Vec3& v) { return Report::list({v.x, v.y, v.z}); }

Report unitName(double metres)
{
	const std::string name = lengthUnitName(metres);
	return name.empty() ? Report(metres) : Report(name);
}

namespace
{
struct FieldUnit
{
	std::string_view field, unit;
};
// Fields of all commands; a name has the same unit in each.
constexpr FieldUnit kUnits[] = {{"volume", "m^3"}, {"mesh_volume", "m^3"}, {"volume_sigma", "m^3"}, {"volume_lower", "m^3"},
	{"volume_change", "%"}, {"volume_doubt", "%"}, {"leaf_volume_change", "%"}, {"area", "m^2"}, {"area_vector", "m^2"},
	{"longest_side", "m"}, {"size", "m"}, {"mean_gap", "m"}, {"max_gap", "m"}, {"min_radius", "m"}, {"surface_error", "m"},
	{"surface_max_error", "m"}, {"sagitta", "m"}, {"center_of_mass", "m"}, {"inertia", "m^5, of density 1"}, {"centroid", "m"},
	{"distance", "m"}, {"distance_lower", "m"}, {"nearest_a", "m"}, {"nearest_b", "m"}, {"max_overlap", "m"}, {"max_protrusion", "m"},
	{"max_center_shift", "m"}, {"max_radius_loss", "m"}, {"max_radius_loss_share", "%"}, {"fill", "%"}, {"fill_loss", "%"},
	{"uncovered_area", "%"}, {"surface_area_error", "%"}, {"surface_open_area", "%"}, {"energy", "J"}, {"force", "N"}, {"force_sigma", "N"},
	{"torque", "N m"}, {"stiffness", "N/m, N; N, N m"}, {"seconds", "s"}, {"bytes", "B"}, {"surface_bytes", "B"},
	{"peak_memory_bytes", "B"}};

std::string unitOf(std::string_view field)
{
	for (const FieldUnit& known : kUnits)
		if (known.field == field) return std::string(known.unit);
	return field.starts_with("seconds_") ? "s" : unitAtEnd(field);
}
}  // namespace

std::string format(const Report& report, bool json) { return json ? report.dump() + "\n" : readableText(report, unitOf); }

double volumeChange(const InnerSphereTree& tree)
{
	if (groundFromText(tree.provenance.repairMode)) return std::numeric_limits<double>::quiet_NaN();
	// Share of the area times the longest side that single-precision coordinates may add. A mesh with less volume enclosed nothing.
	constexpr double kRounding = 0x1p-23;
	const double before = std::fabs(tree.provenance.meshVolume);
	return before > kRounding * tree.area * tree.box.longestSide() ? (tree.volume - before) / before
																   : std::numeric_limits<double>::quiet_NaN();
}

namespace
{
void describeSurface(Report& report, const InnerSphereTree& tree)
{
	const BodySurface& body = tree.surface;
	const double none = std::numeric_limits<double>::quiet_NaN();
	report["surface_elements"] = body.surface.elements.size();
	report["surface_cells"] = body.field.cells.size();
	report["surface_error"] = body.empty() ? none : body.surface.error();
	report["surface_max_error"] = body.empty() ? none : body.surface.largestError();
	report["sagitta"] = tree.sagitta;
	report["surface_bytes"] = body.bytes();
}
}  // namespace

void describeTree(Report& report, const InnerSphereTree& tree, size_t bytes)
{
	const InnerSphereTree::Provenance& p = tree.provenance;
	const double none = std::numeric_limits<double>::quiet_NaN();
	report["spheres"] = tree.spheres.size();
	report["leaves"] = tree.law.ballCount();
	report["fill"] = tree.fill;
	report["volume"] = tree.volume;
	report["mesh_volume"] = p.meshVolume;
	report["area"] = tree.area;
	report["longest_side"] = tree.box.longestSide();
	report["size"] = toJson(tree.box.size());
	report["watertight"] = p.watertight;
	report["repair"] = Report::list();
	for (const std::string& sentence : p.repair) report["repair"].append(withFlags(sentence));
	report["volume_change"] = volumeChange(tree);
	report["mean_gap"] = tree.meanGap;
	report["max_gap"] = tree.maxGap;
	report["min_radius"] = tree.spheres.empty() ? none : static_cast<double>(tree.spheres.back().r);
	report["uncovered_area"] = tree.uncoveredArea;
	describeSurface(report, tree);
	report["bytes"] = bytes;
	report["bytes_per_sphere"] = static_cast<double>(bytes) / static_cast<double>(tree.spheres.size());
	report["bytes_per_leaf"] = static_cast<double>(bytes) / static_cast<double>(tree.law.ballCount());
}

int fail(const std::string& message, int code)
{
	std::fprintf(stderr, "ist: %s\n", withFlags(message).c_str());
	return code;
}

Result<InnerSphereTree> loadTree(const std::string& path)
{
	Result<InnerSphereTree> tree = loadAsset(path);
	std::error_code missing;
	const std::string ending = utf8Path(systemPath(path).extension());
	if (tree || ending == ".ist" || ending == ".ista" || !std::filesystem::is_regular_file(systemPath(path), missing)) return tree;
	return Error{tree.error().message + "; if it is a mesh, make a tree of it: ist build " + path + " -o " +
		utf8Path(systemPath(path).stem()) + ".ist"};
}

void askAboutSize(const std::string& path, double longestSide)
{
	// Larger or smaller things are rare; most are files in millimetres that were read as metres, or the reverse.
	constexpr double kLarge = 100, kSmall = 1e-4;
	if (longestSide <= kLarge && longestSide >= kSmall) return;
	fail("warning: " + path + ": it is " + ist::number(longestSide) + " m long; is that right? If not, give its unit (--unit)", kGood);
}

void warnOfNotTaken(const std::string& path, const Mesh& mesh)
{
	for (const std::string& sentence : mesh.notTaken) fail("warning: " + path + ": " + sentence, kGood);
}
}  // namespace ist::tools
