// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"

#include <pybind11/pybind11.h>

#include <optional>
#include <stdexcept>
#include <utility>

namespace ist::python
{
/// The exception that Python gets for an Error.
struct BulletHapticsError : std::runtime_error
{
	using std::runtime_error::runtime_error;
};

/// Runs offline work without the interpreter's lock. An interrupt or an exception in the caller's `progress` cancels it, and is raised.
template <class Work> auto run(const pybind11::object& progress, Work&& work)
{
	namespace py = pybind11;
	std::optional<py::error_already_set> raised;
	const Progress watch = [&](const char* stage, double fraction) {
		const py::gil_scoped_acquire lock;
		try
		{
			if (PyErr_CheckSignals() != 0) throw py::error_already_set();
			if (progress.is_none()) return true;
			const py::object goOn = progress(stage, fraction);
			const int truth = goOn.is_none() ? 1 : PyObject_IsTrue(goOn.ptr());
			if (truth < 0) throw py::error_already_set();
			return truth == 1;
		}
		catch (py::error_already_set& e)
		{
			raised.emplace(e);
			return false;
		}
	};
	auto result = [&] {
		const py::gil_scoped_release others;
		return work(watch);
	}();
	if (raised) throw py::error_already_set(*raised);
	if (!result) throw BulletHapticsError(result.error().message);
	return std::move(result).value();
}
}  // namespace ist::python
