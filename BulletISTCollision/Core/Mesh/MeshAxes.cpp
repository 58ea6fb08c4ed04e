// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"

#include <array>
#include <utility>

namespace ist
{
std::optional<SignedAxis> signedAxis(std::string_view text)
{
	SignedAxis result;
	if (text.starts_with('-')) result.sign = -1;
	if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
	if (text.size() != 1 || (text[0] | 0x20) < 'x' || (text[0] | 0x20) > 'z') return std::nullopt;
	result.axis = (text[0] | 0x20) - 'x';
	return result;
}

std::string axisName(SignedAxis axis) { return (axis.sign < 0 ? "-" : "") + std::string(1, char('x' + axis.axis)); }

Mesh turnedUp(Mesh mesh, SignedAxis from, SignedAxis to)
{
	if (from.axis == to.axis && from.sign == to.sign) return mesh;
	// A sum with 0.0 makes -0 to 0: the negative of 0 would be -0, which differs from 0 byte by byte.
	for (Vec3& v : mesh.vertices)
	{
		std::array<double, 3> p = {v.x, v.y, v.z};
		const auto f = static_cast<size_t>(from.axis), t = static_cast<size_t>(to.axis);
		if (f == t)
		{
			p[f] = -p[f] + 0.0;
			p[(f + 2) % 3] = -p[(f + 2) % 3] + 0.0;
		}
		else
		{
			const double along = from.sign * p[f], across = to.sign * p[t];
			p[t] = to.sign * along + 0.0;
			p[f] = -from.sign * across + 0.0;
		}
		v = {p[0], p[1], p[2]};
	}
	return mesh;
}

std::optional<UpAxes> upAxes(std::string_view text)
{
	const size_t comma = text.find(',');
	const std::optional<SignedAxis> from = signedAxis(text.substr(0, comma)),
									to = comma == text.npos ? SignedAxis{} : signedAxis(text.substr(comma + 1));
	return from && to ? std::optional(UpAxes{*from, *to}) : std::nullopt;
}

Mesh turnedUp(Mesh mesh, const std::optional<UpAxes>& axes) { return axes ? turnedUp(std::move(mesh), axes->from, axes->to) : mesh; }
}  // namespace ist
