// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// A direction along an axis.
struct SignedAxis
{
	int axis = 1;  ///< 0: x, 1: y, 2: z
	int sign = 1;  ///< 1 or -1
};

/// Reads "x", "+y" or "-z". Empty optional for other texts.
std::optional<SignedAxis> signedAxis(std::string_view text);
/// "x" or "-z"
std::string axisName(SignedAxis axis);

/// The mesh, turned so that what pointed along `from` points along `to`: by a quarter turn about the axis that is neither, or by a half
/// turn if they are opposite. Coordinates change places and signs only, so nothing is rounded.
Mesh turnedUp(Mesh mesh, SignedAxis from, SignedAxis to);

/// The axis of a file that points up, and the axis that it becomes.
struct UpAxes
{
	SignedAxis from, to;
};
/// Reads "z", which becomes y, or "z,-y". Empty optional for other texts.
std::optional<UpAxes> upAxes(std::string_view text);
/// The mesh, turned by these axes if there are any.
Mesh turnedUp(Mesh mesh, const std::optional<UpAxes>& axes);
}  // namespace ist
