// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Python/Tune.h"

#include "BulletISTCollision/Core/Tuning/TuneFigures.h"
#include "BulletISTCollision/Python/MeshArguments.h"
#include "BulletISTCollision/Python/OfflineWork.h"

#include <pybind11/stl.h>

#include <cmath>
#include <string>

namespace py = pybind11;

namespace ist::python
{
namespace
{
TuneBody bodyFrom(const py::object& object, const char* name)
{
	TuneBody body{name, std::nullopt, {}};
	if (py::isinstance<InnerSphereTree>(object))
	{
		body.tree = object.cast<const InnerSphereTree&>();
		return body;
	}
	if (!py::isinstance<py::sequence>(object) || py::isinstance<py::array>(object) || py::len(object) != 2)
		throw py::value_error(std::string(name) + " must be a Tree, or a mesh: the pair (vertices, triangles)");
	const py::sequence mesh(object);
	const Doubles vertices = Doubles::ensure(mesh[0]);
	if (!vertices)
	{
		PyErr_Clear();
		throw py::value_error(std::string(name) + ": vertices must be an array of numbers");
	}
	body.mesh = meshFrom(vertices, mesh[1]);
	return body;
}

void check(const TuneOptions& options)
{
	const WorldSetup& world = options.world;
	const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
	const auto notNegative = [](double value) { return value >= 0 && std::isfinite(value); };
	if (!(options.error > 0 && options.error <= 1)) throw py::value_error("error must be above 0 and at most 1");
	if (options.maxSpheres < 1) throw py::value_error("max_spheres must be at least 1");
	if (world.stiffness && !positive(*world.stiffness)) throw py::value_error("stiffness must be positive and finite");
	if (world.mass && !positive(*world.mass)) throw py::value_error("mass must be positive and finite");
	if (!notNegative(world.speed)) throw py::value_error("speed must be finite and not negative");
	if (!positive(world.step)) throw py::value_error("step must be positive and finite");
	if (!notNegative(world.distance)) throw py::value_error("distance must be finite and not negative");
	const WorldSetup usual;
	const bool asksForWorld = world.stiffness || world.mass || world.speed != usual.speed || world.step != usual.step ||
		world.distance != usual.distance;
	if (!asksForWorld) return;
	if (const std::optional<Error> problem = problemOf(world)) throw py::value_error(problem->message);
}

template <class Figures> py::dict dictOf(const Figures& figures)
{
	py::dict dict;
	eachFigure(figures, [&](const char* name, const auto& value) { dict[name] = value; });
	return dict;
}
}  // namespace

py::dict tune(const py::object& a, const py::object& b, TuneOptions options, const py::object& progress)
{
	check(options);
	TuneBody A = bodyFrom(a, "a"), other;
	if (!a.is(b)) other = bodyFrom(b, "b");
	TuneBody& B = a.is(b) ? A : other;
	const PairTuning tuning = run(progress, [&](const Progress& watch) {
		options.progress = watch;
		return tunePair(A, B, options);
	});
	py::dict answer = dictOf(tuning);
	py::list alternatives;
	for (const TuneSetting& setting : tuning.alternatives) alternatives.append(dictOf(setting));
	answer["alternatives"] = alternatives;
	return answer;
}
}  // namespace ist::python
