// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tuning/PairTuning.h"

#include <pybind11/pybind11.h>

namespace ist::python
{
/// Returns the figures of `ist tune --json` with the same names, None for null; `alternatives` is a list of dicts. Each of `a` and `b` is
/// a tree or a mesh (vertices, triangles). Raises ValueError for options out of range, and bullethaptics.Error if `tunePair` returns an
/// error.
pybind11::dict tune(const pybind11::object& a, const pybind11::object& b, TuneOptions options, const pybind11::object& progress);
}  // namespace ist::python
