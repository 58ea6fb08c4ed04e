// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/ContactSurface.h"

#include "BulletISTCollision/Core/Surface/ElementShape.h"
#include "BulletISTCollision/Core/Surface/SurfaceLimits.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ist
{
namespace
{
constexpr double kRounding = 1e-4;  // relative; larger than what single precision leaves of unit lengths and right angles

/// Change of an element's normal over half of it, an upper bound.
double bendOf(const SurfaceElement& e)
{
	const double k = std::fabs(e.k11) + 2 * std::fabs(e.k12) + std::fabs(e.k22);
	if (k == 0) return 0;
	const Vec3 e1 = toVec3(e.e1), e2 = toVec3(e.e2);
	return k * std::max(norm(e1), norm(e2)) / norm(cross(e1, e2));
}

/// The invariant that an element violates, or an empty string.
std::string faultOf(const SurfaceElement& e)
{
	const Vec3 e1 = toVec3(e.e1), e2 = toVec3(e.e2), normal = toVec3(e.normal);
	if (!isFinite(toVec3(e.center)) || !isFinite(e1) || !isFinite(e2) || !isFinite(normal)) return "is not finite";
	if (!std::isfinite(e.k11) || !std::isfinite(e.k12) || !std::isfinite(e.k22)) return "has a curvature that is not finite";
	if (!(e.area > 0) || !std::isfinite(e.area)) return "has no area";
	if (!(e.error >= 0) || !std::isfinite(e.error)) return "has an error that is negative or not finite";
	if (norm(normal) > 1 + kRounding) return "has a normal longer than 1";
	if (e.isTriangle > 1) return "is neither a triangle nor a parallelogram";
	if (e.isTriangle && (e.k11 != 0 || e.k12 != 0 || e.k22 != 0)) return "is a triangle with a curvature";
	if (!areNear(e.center) || !areNear(e.e1) || !areNear(e.e2) || !isNear(e.error) || !isNear(std::sqrt(e.area)))
		return "is larger than a body";
	if (!(bendOf(e) < kMostBent)) return "is bent too much";
	return {};
}

std::string faultOfBall(const SurfaceNode& n)
{
	if (!isFinite(toVec3(n.center)) || !std::isfinite(n.radius)) return "is not finite";
	if (!(n.radius >= 0)) return "has a negative radius";
	if (!areNear(n.center) || !isNear(n.radius)) return "is larger than a body";
	return {};
}

bool holds(const SurfaceNode& n, const SurfaceElement& e)
{
	for (const Vec3& p : controlPoints(e))
		if (distance(p, toVec3(n.center)) > double(n.radius) * (1 + 1e-6)) return false;
	return true;
}

std::string nameOf(const char* what, size_t index) { return std::string(what) + " " + std::to_string(index) + " "; }

/// Each node but the root is the child of one node before it, and each element belongs to one node.
std::string faultOfTree(const ContactSurface& s)
{
	std::vector<char> nodeUsed(s.nodes.size()), elementUsed(s.elements.size());
	nodeUsed[0] = 1;
	for (size_t i = 0; i < s.nodes.size(); ++i)
	{
		const SurfaceNode& n = s.nodes[i];
		if (!nodeUsed[i]) return nameOf("node", i) + "has no parent before it";
		if (const std::string fault = faultOfBall(n); !fault.empty()) return nameOf("node", i) + fault;
		if (n.isElement())
		{
			if (n.element() >= s.elements.size()) return nameOf("node", i) + "names an element that does not exist";
			if (elementUsed[n.element()]++) return nameOf("element", n.element()) + "belongs to two nodes";
			if (!holds(n, s.elements[n.element()])) return nameOf("node", i) + "does not hold its element";
			continue;
		}
		if (n.child <= i || n.child + size_t(1) >= s.nodes.size()) return nameOf("node", i) + "names children that do not lie behind it";
		for (size_t child = n.child; child < n.child + size_t(2); ++child)
			if (nodeUsed[child]++) return nameOf("node", child) + "has two parents";
	}
	return {};
}
}  // namespace

double ContactSurface::error() const
{
	double sum = 0, area = 0;
	for (const SurfaceElement& e : elements)
	{
		sum += double(e.area) * e.error * e.error;
		area += e.area;
	}
	return area > 0 ? std::sqrt(sum / area) : 0;
}

double ContactSurface::largestError() const
{
	double largest = 0;
	for (const SurfaceElement& e : elements) largest = std::max<double>(largest, e.error);
	return largest;
}

std::string ContactSurface::validate() const
{
	if (elements.empty()) return "the surface has no elements";
	if (nodes.size() != 2 * elements.size() - 1) return "the number of nodes is not twice the number of elements less one";
	for (size_t i = 0; i < elements.size(); ++i)
		if (const std::string fault = faultOf(elements[i]); !fault.empty()) return nameOf("element", i) + fault;
	return faultOfTree(*this);
}
}  // namespace ist
