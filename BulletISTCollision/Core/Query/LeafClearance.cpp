// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/LeafClearance.h"

#include "BulletISTCollision/Core/Tree/TreePose.h"

#include <algorithm>
#include <limits>
#include <new>
#include <type_traits>

namespace ist
{
namespace
{
// kStretch: poses are rigid only within 1e-4. kRounding: queries compare positions as floats.
constexpr double kStretch = 1e-3, kRounding = 1e-5;

struct Ball
{
	uint32_t id;  // node, or block | kLeafBit
	Vec3 center;
	double r;
	bool isBlock() const { return (id & BallNode::kLeafBit) != 0; }
};

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// Always opens the item with the smallest bound. When the budget ends, that bound is the smallest of all.
template <class Item, class Expand> double leastBound(const Item& root, int mostOpened, const Expand& expand)
{
	constexpr int kCapacity = BallNode::kWidth * kMostOpenedForClearance + 1;
	// This array stays uninitialised, because clearing it would cost too much time.
	std::aligned_storage_t<sizeof(Item), alignof(Item)> room[kCapacity];
	Item* heap = reinterpret_cast<Item*>(room);
	const auto later = [](const Item& p, const Item& q) { return p.bound > q.bound; };
	int size = 0, left = std::min(mostOpened, kMostOpenedForClearance);
	new (&heap[size++]) Item(root);
	while (size > 0)
	{
		std::pop_heap(heap, heap + size, later);
		const Item item = heap[--size];
		if (item.isFinal() || left-- <= 0) return std::max(item.bound, 0.0);
		expand(item, [&](const Item& next) {
			new (&heap[size++]) Item(next);
			std::push_heap(heap, heap + size, later);
		});
	}
	return 0;
}

template <class Visit> void forEachChild(const BallNode& node, Visit visit)
{
	for (int k = 0; k < BallNode::kWidth; ++k)
		if (node.child[k] != BallNode::kNoChild) visit(Ball{node.child[k], {node.x[k], node.y[k], node.z[k]}, node.r[k]});
}

struct BallPair
{
	Ball a, b;
	double bound;
	bool isFinal() const { return a.isBlock() && b.isBlock(); }
};

struct BallInField
{
	Ball a;
	double bound;
	bool isFinal() const { return a.isBlock(); }
};

double gap(const Ball& a, const Ball& b)
{
	return distance(a.center, b.center) - a.r - b.r - kRounding * (norm(a.center) + norm(b.center) + a.r + b.r);
}
}  // namespace

double leafClearance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, int mostOpened)
{
	if (!isRigid(X_AB) || A.law.empty() || B.law.empty()) return 0;
	const Pose X = treePose(A, B, X_AB);
	const auto expand = [&](const BallPair& pair, const auto& keep) {
		const bool first = pair.b.isBlock() || (!pair.a.isBlock() && pair.a.r >= pair.b.r);
		forEachChild(first ? A.law.nodes[pair.a.id] : B.law.nodes[pair.b.id], [&](const Ball& child) {
			BallPair next = pair;
			if (first) next.a = child;
			else next.b = {child.id, X * child.center, child.r * (1 + kStretch)};
			// Nothing is known about the bound of a root yet. The other root is opened next.
			next.bound = next.a.r < kUnbounded && next.b.r < kUnbounded ? gap(next.a, next.b) : -kUnbounded;
			keep(next);
		});
	};
	const Ball root{0, {}, kUnbounded};
	return leastBound(BallPair{root, root, -kUnbounded}, mostOpened, expand);
}

double leafClearance(const InnerSphereTree& A, const AnalyticField& field, const Pose& X_AF, int mostOpened)
{
	if (!isRigid(X_AF) || A.law.empty() || !field.isValid()) return 0;
	const Pose X_FA = inverse(Pose{X_AF.rotation, X_AF.translation - A.origin});
	const auto expand = [&](const BallInField& item, const auto& keep) {
		forEachChild(A.law.nodes[item.a.id], [&](const Ball& child) {
			const double rounding = kRounding * (norm(child.center) + norm(X_FA.translation) + child.r);
			keep(BallInField{child, -field.depth(X_FA * child.center) - child.r * (1 + kStretch) - rounding});
		});
	};
	return leastBound(BallInField{{0, {}, kUnbounded}, -kUnbounded}, mostOpened, expand);
}
}  // namespace ist
