// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tuning/PairTuning.h"

#include <pybind11/pybind11.h>

namespace ist::python
{
/// What `ist tune --json` answers, by the same names, None for null; `alternatives` is a list of dicts. Each of `a` and `b` is a tree or a
/// mesh (vertices, triangles). Raises ValueError on options out of range, bullethaptics.Error where `tunePair` has an error.
pybind11::dict tune(const pybind11::object& a, const pybind11::object& b, TuneOptions options, const pybind11::object& progress);
}  // namespace ist::python
