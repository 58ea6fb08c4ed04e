// SPDX-License-Identifier: Zlib
#include "tests/bench/bodies/NaiveSphereTree.h"

#include "BulletISTCollision/Core/Geometry/Lens.h"

#include <algorithm>

using namespace ist;

namespace bench
{
namespace
{
using Node = NaiveSphereTree::Node;
using Overlap = NaiveSphereTree::Overlap;
using Iterator = std::vector<MomentEllipsoid>::iterator;

/// Halves a range at the median of its widest axis.
Iterator halve(Iterator begin, Iterator end)
{
	Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
	for (Iterator b = begin; b != end; ++b)
	{
		low = componentMin(low, b->center());
		high = componentMax(high, b->center());
	}
	const Vec3 size = high - low;
	const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
	const Iterator middle = begin + (end - begin) / 2;
	std::nth_element(
		begin, middle, end, [&](const MomentEllipsoid& p, const MomentEllipsoid& q) { return p.center()[axis] < q.center()[axis]; });
	return middle;
}

void bound(Node& node, Iterator begin, Iterator end)
{
	Vec3 c;
	for (Iterator b = begin; b != end; ++b) c += b->center() / double(end - begin);
	for (int step = 0; step < 20; ++step)
	{
		double reach = 0;
		Vec3 toFarthest;
		for (Iterator b = begin; b != end; ++b)
			if (const double d = distance(b->center(), c) + b->R; d > reach)
			{
				reach = d;
				toFarthest = b->center() - c;
			}
		if (step == 0 || reach < node.r)
		{
			node.r = reach;
			node.center = c;
		}
		c += toFarthest / (step + 3);
	}
	node.r *= 1 + 1e-12;
}

void visit(const Node& a, const Node& b, const Pose& X, Overlap& sum)
{
	const Vec3 centerB = X * b.center;
	++sum.tests;
	const double reach = a.r + b.r;
	if (squaredNorm(a.center - centerB) >= reach * reach) return;
	if (a.leaf() && b.leaf())
	{
		Lens lens;
		if (!lensOf(a.center, a.r, centerB, b.r, lens)) return;
		const Vec3 f = lens.normal * lens.volume;
		sum.volume += lens.volume;
		sum.force += f;
		sum.torque += cross(lens.centroid, f);
		++sum.pairs;
		return;
	}
	const bool openA = b.leaf() || (!a.leaf() && a.r >= b.r);
	for (const auto& child : (openA ? a : b).child)
		if (child) openA ? visit(*child, b, X, sum) : visit(a, *child, X, sum);
}
}  // namespace

std::unique_ptr<Node> NaiveSphereTree::build(std::vector<MomentEllipsoid>& balls, size_t begin, size_t end)
{
	auto node = std::make_unique<Node>();
	const Iterator first = balls.begin() + ptrdiff_t(begin), last = balls.begin() + ptrdiff_t(end);
	if (end - begin == 1)
	{
		node->center = first->center();
		node->r = first->R;
		return node;
	}
	bound(*node, first, last);
	const Iterator middle = halve(first, last);
	Iterator cuts[5] = {first, first, middle, middle, last};
	if (middle - first > 1) cuts[1] = halve(first, middle);
	cuts[3] = last - middle > 1 ? halve(middle, last) : middle;
	int count = 0;
	for (int i = 0; i < 4; ++i)
		if (cuts[i] != cuts[i + 1])
			node->child[count++] = build(balls, size_t(cuts[i] - balls.begin()), size_t(cuts[i + 1] - balls.begin()));
	return node;
}

NaiveSphereTree::NaiveSphereTree(const BallTree& tree)
{
	std::vector<MomentEllipsoid> balls;
	for (size_t slot = 0; slot < tree.slotCount(); ++slot)
		if (const MomentEllipsoid b = tree.ball(slot); b.density > 0) balls.push_back(b);
	m_root = build(balls, 0, balls.size());
}
NaiveSphereTree::~NaiveSphereTree() = default;

Overlap NaiveSphereTree::query(const NaiveSphereTree& A, const NaiveSphereTree& B, const Pose& X)
{
	Overlap sum;
	visit(*A.m_root, *B.m_root, X, sum);
	return sum;
}
}  // namespace bench
