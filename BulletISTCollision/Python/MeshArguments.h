// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <pybind11/numpy.h>

namespace ist::python
{
using Doubles = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

/// Vertices (n, 3) or flat, triangles (m, 3) or flat, or None; then each three vertices are a triangle. Raises ValueError for other
/// shapes, for indices that are not integers, and for indices without a vertex.
Mesh meshFrom(const Doubles& vertices, const pybind11::object& triangles);

/// The arrays (n, 3) of float64 and (m, 3) of int64.
pybind11::tuple arraysFrom(const Mesh& mesh);
}  // namespace ist::python
