// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/BodySurface.h"

#include <array>
#include <cmath>
#include <vector>

/// Integrals over the part of a surface that lies inside a body, in the frame of the body.
struct FaceSums
{
	double area = 0, depth = 0;
	ist::Vec3 areaNormal, pressure, moment;  // moment: integral of x depth dS
};

/// Slow and simple: cuts every element at every plane of the partition, and integrates over small triangles.
class FaceReference
{
public:
	FaceReference(const ist::ContactSurface& surface, const ist::DepthField& field, const ist::Pose& X_FS)
		: m_surface(surface),
		  m_field(field),
		  m_X(X_FS)
	{}

	FaceSums sums()
	{
		for (const ist::SurfaceElement& e : m_surface.elements)
		{
			m_element = &e;
			Polygon polygon = e.isTriangle ? Polygon{{0, 0}, {1, 0}, {0, 1}} : Polygon{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
			for (int axis = 0; axis < 3; ++axis)
			{
				polygon = clipped(polygon, [&](const Point& p) { return m_field.domain.upper[axis] - onPlane(p)[axis]; });
				polygon = clipped(polygon, [&](const Point& p) { return onPlane(p)[axis] - m_field.domain.lower[axis]; });
			}
			overlay(polygon, 0);
		}
		return m_sums;
	}

private:
	using Point = std::array<double, 2>;
	using Polygon = std::vector<Point>;

	static ist::Vec3 vectorOf(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
	ist::Vec3 onPlane(const Point& p) const
	{
		return m_X * (vectorOf(m_element->center) + p[0] * vectorOf(m_element->e1) + p[1] * vectorOf(m_element->e2));
	}
	ist::Vec3 onSheet(const Point& p) const
	{
		const ist::SurfaceElement& e = *m_element;
		const double height = (e.k11 + e.k22) / 6.0 - 0.5 * (e.k11 * p[0] * p[0] + 2 * e.k12 * p[0] * p[1] + e.k22 * p[1] * p[1]);
		return onPlane(p) + height * (m_X.rotation * normalized(vectorOf(e.normal)));
	}

	template <class Distance> static Polygon clipped(const Polygon& polygon, const Distance& distance)
	{
		Polygon kept;
		for (size_t i = 0; i < polygon.size(); ++i)
		{
			const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
			const double a = distance(p), b = distance(q);
			if (a >= 0) kept.push_back(p);
			if ((a < 0) == (b < 0)) continue;
			const double u = a / (a - b);
			kept.push_back({p[0] + u * (q[0] - p[0]), p[1] + u * (q[1] - p[1])});
		}
		return kept.size() < 3 ? Polygon{} : kept;
	}

	void overlay(const Polygon& polygon, uint32_t at)
	{
		if (polygon.empty()) return;
		const ist::DepthNode& node = m_field.nodes[at];
		if (node.deepest < 0) return;
		if (node.isCell())
		{
			for (size_t i = 1; i + 1 < polygon.size(); ++i) addTriangle(polygon[0], polygon[i], polygon[i + 1], node.cell(), 4);
			return;
		}
		overlay(clipped(polygon, [&](const Point& p) { return -node.beyond(onPlane(p)); }), node.child);
		overlay(clipped(polygon, [&](const Point& p) { return node.beyond(onPlane(p)); }), node.child + 1);
	}

	double depthOf(uint32_t index, const ist::Vec3& x) const
	{
		const ist::DepthCell& c = m_field.cells[index];
		const ist::Vec3 y = x - vectorOf(c.center);
		const float(&h)[6] = c.hessian;
		const double bend = h[0] * y.x * y.x + h[1] * y.y * y.y + h[2] * y.z * y.z +
			2 * (h[3] * y.x * y.y + h[4] * y.x * y.z + h[5] * y.y * y.z);
		return c.depth + dot(vectorOf(c.gradient), y) + 0.5 * bend;
	}

	void addTriangle(const Point& a, const Point& b, const Point& c, uint32_t cell, int divisions)
	{
		if (divisions > 0)
		{
			const auto middle = [](const Point& p, const Point& q) { return Point{0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])}; };
			const Point ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
			addTriangle(a, ab, ca, cell, divisions - 1);
			addTriangle(ab, b, bc, cell, divisions - 1);
			addTriangle(ca, bc, c, cell, divisions - 1);
			addTriangle(ab, bc, ca, cell, divisions - 1);
			return;
		}
		const Point p{(a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3};
		const ist::Vec3 x = onSheet(p);
		const double depth = depthOf(cell, x);
		if (depth <= 0) return;
		const ist::SurfaceElement& e = *m_element;
		const double inPlane = 0.5 * std::fabs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
		const double area = inPlane * e.area / (e.isTriangle ? 0.5 : 4);
		ist::Vec3 normal = vectorOf(e.normal);
		const ist::Vec3 e1 = vectorOf(e.e1), e2 = vectorOf(e.e2), product = cross(e1, e2);
		if (!e.isTriangle)
		{
			const ist::Vec3 scaled = product / squaredNorm(product);
			normal += (e.k11 * p[0] + e.k12 * p[1]) * cross(e2, scaled) + (e.k12 * p[0] + e.k22 * p[1]) * cross(scaled, e1);
		}
		normal = m_X.rotation * normal;
		m_sums.area += area;
		m_sums.depth += area * depth;
		m_sums.areaNormal += area * normal;
		m_sums.pressure += (area * depth) * normal;
		m_sums.moment += (area * depth) * x;
	}

	const ist::ContactSurface& m_surface;
	const ist::DepthField& m_field;
	const ist::Pose& m_X;
	const ist::SurfaceElement* m_element = nullptr;
	FaceSums m_sums;
};
