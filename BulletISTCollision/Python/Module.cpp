// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/LengthUnit.h"
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"
#include "BulletISTCollision/Core/Repair/RepairChoice.h"
#include "BulletISTCollision/Core/Tuning/ExpectedError.h"
#include "BulletISTCollision/Python/MeshArguments.h"
#include "BulletISTCollision/Python/OfflineWork.h"
#include "BulletISTCollision/Python/QueryArrays.h"
#include "BulletISTCollision/Python/Tune.h"

#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>

namespace py = pybind11;
using namespace py::literals;

namespace ist::python
{
namespace
{
using Tree = std::shared_ptr<InnerSphereTree>;

RepairChoice repairFrom(const std::string& text)
{
	if (const auto choice = repairChoice(text)) return *choice;
	if (text.starts_with("ground"))
		throw py::value_error("ground needs a depth in metres above 0, and may name the axis that points up: \"ground 2 z\"");
	throw py::value_error("repair must be \"auto\", \"off\", \"wrap\" or like \"ground 2 y\", not \"" + text + "\"");
}

Tree build(const Doubles& vertices, const py::object& triangles, int64_t spheres, double fill, double minRadius,
	std::optional<double> error, const std::string& repair, uint64_t seed, int threads, const py::object& progress, bool surface)
{
	if (spheres < 1) throw py::value_error("spheres must be at least 1");
	if (!(fill > 0 && fill <= 1)) throw py::value_error("fill must be above 0 and at most 1");
	if (!(minRadius >= 0) || !std::isfinite(minRadius)) throw py::value_error("min_radius must be finite and not negative");
	if (error && !(*error > 0 && *error < 1)) throw py::value_error("error must be between 0 and 1");
	if (threads < 0) throw py::value_error("threads must not be negative");
	const Mesh mesh = meshFrom(vertices, triangles);
	BuildOptions options;
	options.maxSpheres = spheres;
	options.targetFill = fill;
	options.minRadius = minRadius;
	const RepairChoice choice = repairFrom(repair);
	options.repair = choice.mode;
	options.ground = choice.ground;
	options.seed = seed;
	options.surface = surface;
	options.threads = threads;
	return std::make_shared<InnerSphereTree>(run(progress, [&](const Progress& watch) {
		options.progress = watch;
		Result<InnerSphereTree> tree = error ? buildTreeToError(mesh, *error, options) : buildTree(mesh, options);
		return tree;
	}));
}

Tree load(const std::filesystem::path& path)
{
	return std::make_shared<InnerSphereTree>(run(py::none(), [&](const Progress&) { return loadAsset(path.string()); }));
}

size_t save(const InnerSphereTree& tree, const std::filesystem::path& path)
{
	return run(py::none(), [&](const Progress& watch) { return saveAsset(tree, path.string(), watch); });
}

py::array_t<float> spheres(const Tree& tree)
{
	static_assert(sizeof(Sphere) == 4 * sizeof(float));
	const py::capsule keep(new Tree(tree), [](void* p) { delete static_cast<Tree*>(p); });
	py::array_t<float> view({static_cast<py::ssize_t>(tree->spheres.size()), py::ssize_t(4)}, &tree->spheres.data()->x, keep);
	py::detail::array_proxy(view.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
	return view;
}

py::array_t<double> toArray(const Vec3& v)
{
	py::array_t<double> a(3);
	a.mutable_at(0) = v.x;
	a.mutable_at(1) = v.y;
	a.mutable_at(2) = v.z;
	return a;
}

py::array_t<double> toArray(const Mat3& m) { return py::array_t<double>({3, 3}, &m.m[0][0]); }

void bindTree(py::module_& module)
{
	py::class_<InnerSphereTree, Tree>(module, "Tree", "A body ready for queries: packed spheres, leaves and their trees. Immutable.")
		.def("save", &save, "path"_a,
			"Writes an .ist asset; the old file or the whole new one is there afterwards. Returns its size in bytes.")
		.def_property_readonly(
			"volume", [](const InnerSphereTree& t) { return t.volume; }, "Of the repaired mesh [m^3].")
		.def_property_readonly(
			"area", [](const InnerSphereTree& t) { return t.area; }, "Of the repaired mesh [m^2].")
		.def_property_readonly(
			"fill", [](const InnerSphereTree& t) { return t.fill; }, "Volume of the packed spheres over that of the mesh.")
		.def_property_readonly(
			"mean_gap", [](const InnerSphereTree& t) { return t.meanGap; }, "Between surface and spheres, mean [m].")
		.def_property_readonly(
			"center_of_mass", [](const InnerSphereTree& t) { return toArray(t.origin); }, "In the mesh frame [m].")
		.def_property_readonly(
			"inertia", [](const InnerSphereTree& t) { return toArray(t.inertia); }, "About the centre of mass, density 1 [m^5].")
		.def_property_readonly("spheres", &spheres, "(n, 4) x y z radius [m], about the centre of mass, largest first; not writable.")
		.def_property_readonly(
			"leaves", [](const InnerSphereTree& t) { return t.law.ballCount(); }, "Number of leaves of the law's tree.")
		.def_property_readonly(
			"elements", [](const InnerSphereTree& t) { return t.surface.surface.elements.size(); }, "Number of elements of the surface.")
		.def_property_readonly(
			"sagitta", [](const InnerSphereTree& t) { return t.sagitta; },
			"Between the mesh's facets and the curved surface that they stand for, largest [m]; an estimate.")
		.def_property_readonly(
			"repair", [](const InnerSphereTree& t) { return t.provenance.repair; }, "What repair did to the mesh, in sentences.")
		.def("__repr__", [](const InnerSphereTree& t) {
			return "<bullethaptics.Tree of " + std::to_string(t.spheres.size()) + " spheres, " + std::to_string(t.law.ballCount()) +
				" leaves>";
		});
}

void warnOfNotTaken(const std::string& path, const Mesh& mesh)
{
	for (const std::string& sentence : mesh.notTaken)
		if (PyErr_WarnEx(PyExc_UserWarning, (path + ": " + sentence).c_str(), 1) != 0) throw py::error_already_set();
}

std::optional<double> metresOf(const std::optional<std::variant<double, std::string>>& unit)
{
	if (!unit) return std::nullopt;
	if (const double* metres = std::get_if<double>(&*unit)) return *metres;
	const std::string& name = std::get<std::string>(*unit);
	const std::optional<double> metres = lengthUnit(name);
	if (!metres) throw py::value_error("unit must be metres, or \"m\", \"cm\", \"mm\", \"um\", \"in\" or \"ft\", not \"" + name + "\"");
	return metres;
}

void bindFunctions(py::module_& module)
{
	module.def("build", &build, "vertices"_a, "triangles"_a = py::none(), py::kw_only(), "spheres"_a = int64_t(10000), "fill"_a = 1.0,
		"min_radius"_a = 0.0, "error"_a = py::none(), "repair"_a = "auto", "seed"_a = uint64_t(1), "threads"_a = 0,
		"progress"_a = py::none(), "surface"_a = true,
		"A tree from a mesh [m]: vertices (n, 3) or flat, triangles (m, 3) or flat, counter-clockwise seen from outside; without "
		"triangles, "
		"each three vertices are one. `error`: force error at 1 % overlap to reach with at most `spheres`. `repair`: \"auto\", \"off\", "
		"\"wrap\", or \"ground 2 y\", which closes open ground downwards, 2 m below its lowest point. `progress(stage, fraction)` may "
		"return False to cancel. `surface=False`: without what contact below the gaps between spheres is computed from. Raises "
		"bullethaptics.Error "
		"with a sentence.");
	module.def("load", &load, "path"_a, "A tree from an .ist or .ista file.");
	module.def(
		"read_mesh",
		[](const std::filesystem::path& path, const std::optional<std::variant<double, std::string>>& unit,
			const std::optional<std::string>& up) {
			const std::optional<double> metres = metresOf(unit);
			const std::optional<UpAxes> axes = up ? upAxes(*up) : std::nullopt;
			if (up && !axes) throw py::value_error("up must be an axis like \"z\" or \"-x\", or two like \"z,y\", not \"" + *up + "\"");
			const Mesh mesh = run(py::none(), [&](const Progress& watch) { return importMesh(path.string(), metres, watch); });
			warnOfNotTaken(path.string(), mesh);
			return arraysFrom(turnedUp(mesh, axes));
		},
		"path"_a, "unit"_a = py::none(), "up"_a = py::none(),
		"(vertices, triangles) of a mesh file [m]. `unit`, metres per unit of the file or one of \"m\", \"cm\", \"mm\", \"um\", \"in\" and "
		"\"ft\", takes the place of the one that the file states, if any. `up`, the file's axis that points up, becomes y; \"z,x\" names "
		"another one. What was not taken is a UserWarning.");
	module.def("query", &query, "a"_a, "b"_a, "poses"_a, py::kw_only(), "stiffness"_a = 1.0, "level"_a = -1, "max_pairs"_a = int64_t(-1),
		"error"_a = py::none(),
		"Overlap, force and torque of body b at `poses` in a's mesh frame, by the pressure field law with `stiffness` [Pa/m]. A dict of "
		"arrays, "
		"a row for each pose; force and torque act on a, in a's axes, about a's centre of mass. `error`, 0..1: each pose is answered "
		"at the coarsest level that keeps this force error, with two more columns: `promise`, the force error that holds in 95 % of "
		"contacts, and "
		"`kept`. `level`, the finest one allowed then, `max_pairs` and `error` need trees with levels: with_levels().");
	module.def("contact_surface", &contactSurface, "a"_a, "b"_a, "pose"_a, py::kw_only(), "stiffness"_a = 1.0,
		"The contact surface of body b at `pose` in a's mesh frame: a dict of arrays with a row for each point. `position` in a's mesh "
		"frame "
		"[m], `normal`: direction of the force on a, `area` [m^2], `pressure` [Pa], `error`: its standard error [Pa], `of_a`: whether the "
		"area is of a's surface. The sum of area * pressure * normal is the force of query().");
	const WorldSetup usual;
	module.def(
		"tune",
		[](const py::object& a, const py::object& b, double error, int64_t maxSpheres, std::optional<double> stiffness,
			std::optional<double> mass, double speed, double step, double distance, const py::object& progress) {
			return tune(a, b, TuneOptions{error, maxSpheres, WorldSetup{stiffness, mass, speed, step, distance}, {}}, progress);
		},
		"a"_a, "b"_a, "error"_a, py::kw_only(), "max_spheres"_a = TuneOptions{}.maxSpheres, "stiffness"_a = py::none(),
		"mass"_a = py::none(), "speed"_a = usual.speed, "step"_a = usual.step, "distance"_a = usual.distance, "progress"_a = py::none(),
		"The cheapest level of two bodies that promises a force error, 0..1, in 95 % of poses between 0.1 and 20 % overlap: a dict of what "
		"`ist tune "
		"--json` prints, None for null. A body is a Tree, or a mesh (vertices, triangles), of which trees of up to `max_spheres` are built "
		"until one will do. "
		"`kept` is False when the error is out of reach. With `stiffness` of the pair [Pa/m] and `mass` of the lighter body [kg], also "
		"what the world must be "
		"like: `speed` with which they meet [m/s], `step` of the world [s], `distance` from its origin [m].");
	module.def("distance", &distance, "a"_a, "b"_a, "poses"_a, "(upper, lower) bound of the distance [m].");
	module.def("relative_pose", &relativePose, "pose_a"_a, "pose_b"_a, "The pose of b in a's frame, from the poses of both in the world.");
	module.def(
		"with_levels",
		[](const InnerSphereTree& tree) {
			const py::gil_scoped_release others;
			InnerSphereTree copy = tree;
			addLevels(copy);
			return std::make_shared<InnerSphereTree>(std::move(copy));
		},
		"tree"_a, "The same body with coarser versions of its leaves.");
}
}  // namespace

PYBIND11_MODULE(bullethaptics, module)
{
	module.doc() = "Volumetric contact between closed meshes: inner sphere trees and what their overlap says of force and torque.";
	module.attr("__version__") = BULLETHAPTICS_VERSION;
	py::register_exception<BulletHapticsError>(module, "Error");
	bindTree(module);
	bindFunctions(module);
}
}  // namespace ist::python
