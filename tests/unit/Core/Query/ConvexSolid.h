// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

/// A convex polyhedron that is clipped at planes, with its exact volume and centroid: an oracle that shares no code with the queries.
class ConvexSolid
{
public:
	/// A box about the origin.
	static ConvexSolid box(const ist::Vec3& half)
	{
		ConvexSolid solid;
		for (int axis = 0; axis < 3; ++axis)
			for (const double sign : {1.0, -1.0})
			{
				ist::Vec3 at, u, v;
				at[axis] = sign * half[axis];
				u[(axis + 1) % 3] = half[(axis + 1) % 3];
				v[(axis + 2) % 3] = half[(axis + 2) % 3];
				solid.m_faces.push_back({at - u - v, at + u - v, at + u + v, at - u + v});
			}
		return solid;
	}

	ConvexSolid placed(const ist::Pose& X) const
	{
		ConvexSolid solid = *this;
		for (auto& face : solid.m_faces)
			for (ist::Vec3& p : face) p = X * p;
		return solid;
	}

	/// The part with normal . x <= offset.
	ConvexSolid below(const ist::Vec3& normal, double offset) const
	{
		ConvexSolid solid;
		std::vector<ist::Vec3> rim;
		for (const auto& face : m_faces)
		{
			std::vector<ist::Vec3> kept;
			for (size_t i = 0; i < face.size(); ++i)
			{
				const ist::Vec3 &p = face[i], &q = face[(i + 1) % face.size()];
				const double a = dot(normal, p) - offset, b = dot(normal, q) - offset;
				if (a <= 0) kept.push_back(p);
				if ((a < 0 && b > 0) || (a > 0 && b < 0))
				{
					kept.push_back(p + a / (a - b) * (q - p));
					rim.push_back(kept.back());
				}
				else if (a == 0) rim.push_back(p);
			}
			if (kept.size() > 2) solid.m_faces.push_back(std::move(kept));
		}
		if (rim.size() > 2) solid.m_faces.push_back(sorted(std::move(rim), normal));
		return solid;
	}

	double volume() const { return moments().first; }
	ist::Vec3 centroid() const
	{
		const auto [volume, first] = moments();
		return first / volume;
	}

private:
	/// Sorts points around their mean.
	static std::vector<ist::Vec3> sorted(std::vector<ist::Vec3> points, const ist::Vec3& normal)
	{
		ist::Vec3 mean, farthest;
		for (const ist::Vec3& p : points) mean += p / double(points.size());
		for (const ist::Vec3& p : points)
			if (distance(p, mean) > norm(farthest)) farthest = p - mean;
		const ist::Vec3 u = normalized(farthest), v = cross(normalized(normal), u);
		const auto angle = [&](const ist::Vec3& p) { return std::atan2(dot(v, p - mean), dot(u, p - mean)); };
		std::sort(points.begin(), points.end(), [&](const ist::Vec3& p, const ist::Vec3& q) { return angle(p) < angle(q); });
		return points;
	}

	/// Sums over tetrahedra from a point inside. Their volumes are positive, so the orientation of a face does not matter.
	std::pair<double, ist::Vec3> moments() const
	{
		ist::Vec3 inside;
		double count = 0, volume = 0;
		for (const auto& face : m_faces)
			for (const ist::Vec3& p : face) inside += p, ++count;
		if (count > 0) inside = inside / count;
		ist::Vec3 first;
		for (const auto& face : m_faces)
			for (size_t i = 2; i < face.size(); ++i)
			{
				const ist::Vec3 &a = face[0], &b = face[i - 1], &c = face[i];
				const double v = std::fabs(dot(a - inside, cross(b - inside, c - inside))) / 6;
				volume += v;
				first += 0.25 * v * (inside + a + b + c);
			}
		return {volume, first};
	}

	std::vector<std::vector<ist::Vec3>> m_faces;
};
