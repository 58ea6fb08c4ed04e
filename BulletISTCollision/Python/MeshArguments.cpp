// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Python/MeshArguments.h"

#include <limits>
#include <string>

namespace py = pybind11;

namespace ist::python
{
namespace
{
using Indices = py::array_t<int64_t, py::array::c_style | py::array::forcecast>;

/// The number of triples in an array of shape (n, 3) or (3 n).
py::ssize_t triples(const py::array& array, const char* name)
{
	const bool rows = array.ndim() == 2 && array.shape(1) == 3;
	const bool flat = array.ndim() == 1 && array.size() % 3 == 0;
	if (!rows && !flat) throw py::value_error(std::string(name) + " must have the shape (n, 3), or be a flat list of 3 n numbers");
	return array.size() / 3;
}

Indices wholeNumbers(const py::object& object)
{
	const py::array array = py::array::ensure(object);
	if (!array) throw py::value_error("triangles must be an array of vertex indices");
	const char kind = array.dtype().kind();
	if (array.size() > 0 && kind != 'i' && kind != 'u') throw py::value_error("triangles must be whole numbers: indices of vertices");
	return Indices::ensure(array);
}

uint32_t vertexIndex(int64_t index, size_t vertices)
{
	if (index < 0 || index >= static_cast<int64_t>(vertices))
		throw py::value_error("triangles name vertex " + std::to_string(index) + ", but there are " + std::to_string(vertices));
	return static_cast<uint32_t>(index);
}
}  // namespace

Mesh meshFrom(const Doubles& vertices, const py::object& triangles)
{
	Mesh mesh;
	const py::ssize_t count = triples(vertices, "vertices");
	if (count > std::numeric_limits<uint32_t>::max()) throw py::value_error("vertices: more than a mesh can index");
	mesh.vertices.reserve(static_cast<size_t>(count));
	const double* v = vertices.data();
	for (py::ssize_t i = 0; i < count; ++i) mesh.vertices.push_back({v[3 * i], v[3 * i + 1], v[3 * i + 2]});

	if (triangles.is_none())
	{
		if (count % 3 != 0) throw py::value_error("without triangles, each three vertices are one, but there are " + std::to_string(count));
		for (uint32_t i = 0; i < static_cast<uint32_t>(count); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
		return mesh;
	}
	const Indices indices = wholeNumbers(triangles);
	const py::ssize_t corners = 3 * triples(indices, "triangles");
	const int64_t* t = indices.data();
	for (py::ssize_t i = 0; i < corners; i += 3)
		mesh.triangles.push_back({vertexIndex(t[i], mesh.vertices.size()), vertexIndex(t[i + 1], mesh.vertices.size()),
			vertexIndex(t[i + 2], mesh.vertices.size())});
	return mesh;
}

py::tuple arraysFrom(const Mesh& mesh)
{
	py::array_t<double> vertices({static_cast<py::ssize_t>(mesh.vertices.size()), py::ssize_t(3)});
	py::array_t<int64_t> triangles({static_cast<py::ssize_t>(mesh.triangles.size()), py::ssize_t(3)});
	double* v = vertices.mutable_data();
	for (const Vec3& p : mesh.vertices)
		for (double x : {p.x, p.y, p.z}) *v++ = x;
	int64_t* t = triangles.mutable_data();
	for (const auto& triangle : mesh.triangles)
		for (uint32_t i : triangle) *t++ = i;
	return py::make_tuple(vertices, triangles);
}
}  // namespace ist::python
