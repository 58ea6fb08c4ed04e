// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/Unwrap.h"

#include <algorithm>
#include <array>
#include <cmath>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr double kFrame = 0.03;  // border on each side, as a share of an island's width; triangles at a seam reach into it

/// A rectangle of the picture.
struct Island
{
	double left, low, right, high;

	/// Place in the picture; `x` and `y` go from 0 to 1 across the island.
	TexturePlace place(double x, double y) const
	{
		const auto inner = [](double from, double to, double t) { return from + (to - from) * (kFrame + (1 - 2 * kFrame) * t); };
		return {inner(left, right, x), inner(low, high, y)};
	}
};
// The sides of the islands are in proportion to those of a mug.
constexpr Island kOutside{0, 0.56, 1, 1}, kInside{0, 0.26, 0.62, 0.54}, kUp{0.66, 0.3, 0.9, 0.54}, kDown{0.66, 0.02, 0.9, 0.26},
	kHandle{0, 0.02, 0.62, 0.24};

double turns(double angle) { return 0.5 + angle / (2 * kPi); }
/// The same angle, at most pi away from `other`.
double near(double angle, double other) { return other + std::remainder(angle - other, 2 * kPi); }

class Unwrapping
{
public:
	Unwrapping(const Mesh& mesh, const TurnedHandle* handle) : m_mesh(mesh), m_box(bounds(mesh))
	{
		for (const Vec3& p : mesh.vertices)
			if (!handle || !handle->has(p)) m_widest = std::max(m_widest, std::hypot(p.x, p.z));
	}

	std::array<TexturePlace, 3> unrolled(const Island& island, const std::array<uint32_t, 3>& t, double middle) const
	{
		return each(t,
			[&](const Vec3& p) { return island.place(turns(near(std::atan2(p.z, p.x), middle)), (p.y - m_box.lower.y) / m_box.size().y); });
	}
	std::array<TexturePlace, 3> seenAlongY(const Island& island, const std::array<uint32_t, 3>& t) const
	{
		return each(t, [&](const Vec3& p) { return island.place(0.5 + 0.5 * p.x / m_widest, 0.5 + 0.5 * p.z / m_widest); });
	}
	template <class Place> std::array<TexturePlace, 3> each(const std::array<uint32_t, 3>& t, const Place& place) const
	{
		return {place(m_mesh.vertices[t[0]]), place(m_mesh.vertices[t[1]]), place(m_mesh.vertices[t[2]])};
	}

private:
	const Mesh& m_mesh;
	Box m_box;
	double m_widest = 0;
};
}  // namespace

TexturedMesh unwrapTurned(const Mesh& mesh, const TurnedHandle* handle)
{
	const Unwrapping unwrapping(mesh, handle);
	TexturedMesh out{mesh, {}};
	for (const auto& t : mesh.triangles)
	{
		const Vec3 a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]], middle = (a + b + c) / 3,
				   normal = cross(b - a, c - a);
		if (handle && handle->has(middle))
		{
			const double along = handle->along(middle), around = handle->around(middle);
			out.places.push_back(unwrapping.each(t, [&](const Vec3& p) {
				return kHandle.place(turns(near(handle->along(p), along)), turns(near(handle->around(p), around)));
			}));
			continue;
		}
		const double outwards = (normal.x * middle.x + normal.z * middle.z) / std::max(std::hypot(middle.x, middle.z), 1e-12);
		if (std::fabs(outwards) >= std::fabs(normal.y))
			out.places.push_back(unwrapping.unrolled(outwards > 0 ? kOutside : kInside, t, std::atan2(middle.z, middle.x)));
		else out.places.push_back(unwrapping.seenAlongY(normal.y > 0 ? kUp : kDown, t));
	}
	return out;
}
}  // namespace scenes
