// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/DepthField.h"

#include "BulletISTCollision/Core/Surface/SurfaceLimits.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ist
{
namespace
{
constexpr double kUnitTolerance = 1e-5;  // for the length of a normal in floats

template <int N> bool areFinite(const float (&values)[N])
{
	return std::all_of(values, values + N, [](float v) { return std::isfinite(v); });
}

std::string named(const char* what, size_t index, const char* fault)
{
	return std::string(what) + ' ' + std::to_string(index) + ": " + fault;
}

std::string faultOfDomain(const Box& domain)
{
	if (!isFinite(domain.lower) || !isFinite(domain.upper)) return "the domain is not finite";
	for (int axis = 0; axis < 3; ++axis)
		if (!isNear(domain.lower[axis]) || !isNear(domain.upper[axis])) return "the domain is larger than a body";
	const Vec3 size = domain.size();
	return size.x > 0 && size.y > 0 && size.z > 0 ? "" : "the domain is empty";
}

std::string faultOfMargin(double margin) { return isNear(margin) && margin >= 0 ? "" : "the margin is negative or not finite"; }

/// `size`: longest side of the domain [m].
std::string faultOfCell(const DepthCell& cell, double size, size_t index)
{
	const float numbers[] = {cell.depth, cell.error, cell.radius};
	if (!areFinite(cell.center) || !areFinite(cell.gradient) || !areFinite(cell.hessian) || !areFinite(numbers))
		return named("cell", index, "a value is not finite");
	if (cell.error < 0 || cell.radius < 0) return named("cell", index, "its error or radius is negative");
	if (!areNear(cell.center) || !areNear(numbers)) return named("cell", index, "it is larger than a body");
	for (float g : cell.gradient)
		if (std::fabs(g) > kSteepest) return named("cell", index, "its gradient is too long");
	for (float h : cell.hessian)
		if (std::fabs(h) * size > kMostBent) return named("cell", index, "its depth is bent too much");
	return "";
}

std::string faultOfPlane(const DepthNode& node, size_t index)
{
	if (!areFinite(node.normal) || !isNear(node.offset))
		return named("node", index, "its plane is not finite, or farther away than a body reaches");
	const Vec3 normal{node.normal[0], node.normal[1], node.normal[2]};
	return std::fabs(norm(normal) - 1) <= kUnitTolerance ? "" : named("node", index, "its normal has not unit length");
}

/// Checks the nodes and notes which nodes and cells they lead to.
class NodeCheck
{
public:
	explicit NodeCheck(const DepthField& field) : m_field(field), m_nodeUsed(field.nodes.size()), m_cellUsed(field.cells.size()) {}

	std::string run()
	{
		m_nodeUsed[0] = 1;
		for (size_t i = 0; i < m_field.nodes.size(); ++i)
		{
			const DepthNode& node = m_field.nodes[i];
			if (!isNear(node.deepest)) return named("node", i, "its largest depth is not finite, or larger than a body");
			std::string fault = node.isCell() ? useCell(node, i) : useChildren(node, i);
			if (!fault.empty()) return fault;
		}
		for (size_t i = 0; i < m_nodeUsed.size(); ++i)
			if (!m_nodeUsed[i]) return named("node", i, "no node leads to it");
		for (size_t i = 0; i < m_cellUsed.size(); ++i)
			if (!m_cellUsed[i]) return named("cell", i, "no node leads to it");
		return "";
	}

private:
	std::string useCell(const DepthNode& node, size_t index)
	{
		if (node.isOutside()) return node.deepest < 0 ? "" : named("node", index, "it is outside, but its depth is not negative");
		if (node.cell() >= m_cellUsed.size()) return named("node", index, "its cell does not exist");
		if (m_cellUsed[node.cell()]++) return named("node", index, "its cell belongs to another node");
		return "";
	}

	std::string useChildren(const DepthNode& node, size_t index)
	{
		std::string fault = faultOfPlane(node, index);
		if (!fault.empty()) return fault;
		if (node.child <= index) return named("node", index, "its children do not come after it");
		if (size_t(node.child) + 1 >= m_nodeUsed.size()) return named("node", index, "its children do not exist");
		const DepthNode* children = &m_field.nodes[node.child];
		if (children[0].isOutside() || (children[1].isOutside() && !children[0].isCell()))
			return named("node", index, "its child is outside, but the first child is not a cell");
		for (const size_t child : {size_t(node.child), size_t(node.child) + 1})
		{
			if (m_nodeUsed[child]++) return named("node", index, "its child belongs to another node");
			if (m_field.nodes[child].deepest > node.deepest) return named("node", index, "its child has a larger depth");
		}
		return "";
	}

	const DepthField& m_field;
	std::vector<char> m_nodeUsed, m_cellUsed;
};
}  // namespace

DepthCell::Value DepthCell::at(const Vec3& x) const
{
	const Vec3 y{x.x - center[0], x.y - center[1], x.z - center[2]};
	const float(&h)[6] = hessian;
	const Vec3 bend{h[0] * y.x + h[3] * y.y + h[4] * y.z, h[3] * y.x + h[1] * y.y + h[5] * y.z, h[4] * y.x + h[5] * y.y + h[2] * y.z};
	const Vec3 slope{gradient[0], gradient[1], gradient[2]};
	return {depth + dot(slope, y) + 0.5 * dot(bend, y), slope + bend};
}

DepthField::Value DepthField::at(const Vec3& x) const
{
	const DepthNode *node = nodes.data(), *above = node;
	while (!node->isCell())
	{
		above = node;
		node = &nodes[node->child + (node->beyond(x) > 0 ? 1 : 0)];
	}
	if (node->isOutside()) return {-above->beyond(x), -Vec3{above->normal[0], above->normal[1], above->normal[2]}, DepthNode::kOutside};
	const auto [depth, gradient] = cells[node->cell()].at(x);
	// The polynomial of a cell outside of the body may be positive somewhere between the samples.
	return {node->deepest < 0 ? std::min(depth, double(node->deepest)) : depth, gradient, node->cell()};
}

std::string DepthField::validate() const
{
	if (nodes.empty()) return "there is no node";
	if (nodes[0].isOutside()) return "the root is outside";
	std::string fault = faultOfDomain(domain);
	if (fault.empty()) fault = faultOfMargin(margin);
	for (size_t i = 0; fault.empty() && i < cells.size(); ++i) fault = faultOfCell(cells[i], domain.longestSide(), i);
	return fault.empty() ? NodeCheck(*this).run() : fault;
}
}  // namespace ist
