// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/LeafClearance.h"

#include "BulletISTCollision/Core/Query/PlanarBody.h"
#include "BulletISTCollision/Core/Tree/TreePose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <type_traits>

namespace ist
{
namespace
{
// kStretch: poses are rigid only within 1e-4. kRounding: queries compare positions as floats.
constexpr double kStretch = 1e-3, kRounding = 1e-5;

/// Depth and surface may be wrong by so many of their largest standard errors: contact begins before the elements meet.
constexpr double kErrorsOfSurfaces = 4;
constexpr int kOpenedOfBinary = 4;  // binary nodes are opened for one of eight children, at about the same cost

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
	int size = 0, left = std::min(mostOpened, kCapacity - 1);
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

/// Clearance of two balls, less what rounding may take from it.
template <class Any> double gap(const Any& a, const Any& b)
{
	return distance(a.center, b.center) - a.r - b.r - kRounding * (norm(a.center) + norm(b.center) + a.r + b.r);
}

/// A ball of a surface: a node of its tree.
struct SurfaceBall
{
	uint32_t child;
	Vec3 center;
	double r;
	bool isElement() const { return (child & SurfaceNode::kElement) != 0; }
};

SurfaceBall ballOf(const SurfaceNode& node) { return {node.child, toVec3(node.center), node.radius}; }

struct SurfaceBallPair
{
	SurfaceBall a, b;
	double bound;
	bool isFinal() const { return a.isElement() && b.isElement(); }
};

/// A flat element, in A's tree frame: a parallelogram or a triangle.
struct FlatPiece
{
	Vec3 center, e1, e2, normal;
	bool isTriangle;

	/// Lower bound of the distance: exact but beyond the corners, where it is that of the nearer edge's line.
	double distanceTo(const Vec3& p) const
	{
		const Vec3 q = p - center;
		double outside = 0;
		const auto beyond = [&](const Vec3& along, const Vec3& from, const Vec3& inside) {
			const Vec3 u = normalized(cross(along, normal));
			const double side = dot(u, q - from);
			if (isTriangle) outside = std::max(outside, dot(u, inside - from) > 0 ? -side : side);
			else outside = std::max(outside, std::fabs(dot(u, q)) - std::fabs(dot(u, inside)));
		};
		beyond(e1, {}, e2);
		beyond(e2, {}, e1);
		if (isTriangle) beyond(e2 - e1, e1, {});
		const double above = dot(normal, q);
		return std::sqrt(above * above + outside * outside);
	}
	/// Largest projection on the direction.
	double reach(const Vec3& u) const
	{
		const double a = dot(e1, u), b = dot(e2, u);
		return dot(center, u) + (isTriangle ? std::max({0.0, a, b}) : std::fabs(a) + std::fabs(b));
	}
};

bool isFlat(const SurfaceElement& e) { return e.k11 == 0 && e.k12 == 0 && e.k22 == 0 && e.error == 0; }

FlatPiece pieceOf(const SurfaceElement& e, const Pose& X)
{
	const Mat3& R = X.rotation;
	return {X * toVec3(e.center), R * toVec3(e.e1), R * toVec3(e.e2), R * toVec3(e.normal), e.isTriangle != 0};
}

/// Lower bound of the distance of a flat element from what a ball contains.
double gapOfBall(const FlatPiece& piece, const SurfaceBall& ball)
{
	return piece.distanceTo(ball.center) - ball.r -
		kRounding * (norm(piece.center) + norm(piece.e1) + norm(piece.e2) + norm(ball.center) + ball.r);
}

/// Lower bound of the distance of two flat elements: the largest of their gaps along some directions.
double gapOfPieces(const FlatPiece& a, const FlatPiece& b)
{
	double largest = -kUnbounded;
	for (const Vec3& along : {a.normal, -1.0 * b.normal, a.normal - b.normal, b.center - a.center})
		if (const double length = norm(along); length > 0)
		{
			const Vec3 u = along / length;
			largest = std::max(largest, -b.reach(-1.0 * u) - a.reach(u));
		}
	return largest - kRounding * (norm(a.center) + norm(b.center) + norm(a.e1) + norm(a.e2) + norm(b.e1) + norm(b.e2));
}

double surfaceClearance(const ContactSurface& A, const ContactSurface& B, const Pose& X, int mostOpened)
{
	const auto placed = [&](const SurfaceNode& node) {
		const SurfaceBall ball = ballOf(node);
		return SurfaceBall{ball.child, X * ball.center, ball.r * (1 + kStretch)};
	};
	const auto flatPiece = [](const ContactSurface& surface, const SurfaceBall& ball, const Pose& X_AS) -> std::optional<FlatPiece> {
		if (!ball.isElement()) return std::nullopt;
		const SurfaceElement& element = surface.elements[ball.child & ~SurfaceNode::kElement];
		return isFlat(element) ? std::optional(pieceOf(element, X_AS)) : std::nullopt;
	};
	// Large flat elements fill little of their balls.
	const auto gapOf = [&](const SurfaceBallPair& pair) {
		double largest = gap(pair.a, pair.b);
		if (largest > 0) return largest;
		const std::optional<FlatPiece> a = flatPiece(A, pair.a, {}), b = flatPiece(B, pair.b, X);
		if (a) largest = std::max(largest, gapOfBall(*a, pair.b));
		if (b) largest = std::max(largest, gapOfBall(*b, pair.a));
		if (a && b) largest = std::max(largest, gapOfPieces(*a, *b));
		return largest;
	};
	const auto expand = [&](const SurfaceBallPair& pair, const auto& keep) {
		const bool first = pair.b.isElement() || (!pair.a.isElement() && pair.a.r >= pair.b.r);
		for (uint32_t k = 0; k < 2; ++k)
		{
			SurfaceBallPair next = pair;
			if (first) next.a = ballOf(A.nodes[pair.a.child + k]);
			else next.b = placed(B.nodes[pair.b.child + k]);
			next.bound = gapOf(next);
			keep(next);
		}
	};
	const SurfaceBallPair roots{ballOf(A.nodes[0]), placed(B.nodes[0]), -kUnbounded};
	return leastBound(roots, kOpenedOfBinary * std::min(mostOpened, kMostOpenedForClearance), expand);
}

struct SurfaceBallInField
{
	SurfaceBall a;
	double bound;
	bool isFinal() const { return a.isElement(); }
};

/// Lower bound of the distance of a flat element from a body with flat sides: the largest of its distances from the sides' planes. X: pose
/// of the element's frame in the field's.
double gapOfPiece(const SurfaceElement& e, const AnalyticField& field, const Pose& X)
{
	const Vec3 center = X * toVec3(e.center), e1 = X.rotation * toVec3(e.e1), e2 = X.rotation * toVec3(e.e2);
	double largest = -kUnbounded;
	for (int i = 0; i < field.sideCount(); ++i)
	{
		const FieldSide side = field.side(i, center, {});
		const double a = dot(side.normal, e1), b = dot(side.normal, e2);
		const double reach = e.isTriangle ? std::max({0.0, -a, -b}) : std::fabs(a) + std::fabs(b);
		largest = std::max(largest, -side.depth - reach);
	}
	return largest - kRounding * (norm(center) + norm(e1) + norm(e2));
}

double surfaceClearance(const ContactSurface& A, const AnalyticField& field, const Pose& X_FA, int mostOpened)
{
	const auto boundOf = [&](const SurfaceBall& ball) {
		const double rounding = kRounding * (norm(ball.center) + norm(X_FA.translation) + ball.r);
		const double gap = -field.depth(X_FA * ball.center) - ball.r * (1 + kStretch) - rounding;
		if (gap > 0 || !ball.isElement()) return gap;
		const SurfaceElement& e = A.elements[ball.child & ~SurfaceNode::kElement];
		return isFlat(e) ? std::max(gap, gapOfPiece(e, field, X_FA)) : gap;
	};
	const auto expand = [&](const SurfaceBallInField& item, const auto& keep) {
		for (uint32_t k = 0; k < 2; ++k)
		{
			const SurfaceBall ball = ballOf(A.nodes[item.a.child + k]);
			keep(SurfaceBallInField{ball, boundOf(ball)});
		}
	};
	const int opened = kOpenedOfBinary * std::min(mostOpened, kMostOpenedForClearance);
	return leastBound(SurfaceBallInField{ballOf(A.nodes[0]), -kUnbounded}, opened, expand);
}
}  // namespace

double leafClearance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, int mostOpened)
{
	if (!isRigid(X_AB) || A.law.empty() || B.law.empty()) return 0;
	const Pose X = treePose(A, B, X_AB);
	if (!A.surface.empty() && !B.surface.empty())
	{
		const double between = surfaceClearance(A.surface.surface, B.surface.surface, X, mostOpened);
		return std::max(between - kErrorsOfSurfaces * (double(A.surface.tables.error) + double(B.surface.tables.error)), 0.0);
	}
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
	return leastBound(BallPair{root, root, -kUnbounded}, std::min(mostOpened, kMostOpenedForClearance), expand);
}

double leafClearance(const InnerSphereTree& A, const AnalyticField& field, const Pose& X_AF, int mostOpened)
{
	if (!isRigid(X_AF) || A.law.empty() || !field.isValid()) return 0;
	const Pose X_FA = inverse(Pose{X_AF.rotation, X_AF.translation - A.origin});
	if (!A.surface.empty() && PlanarBody::canLayOut(field, ballAround(A.surface.surface, X_FA)))
	{
		const double between = surfaceClearance(A.surface.surface, field, X_FA, mostOpened);
		return std::max(between - kErrorsOfSurfaces * double(A.surface.tables.error), 0.0);
	}
	const auto expand = [&](const BallInField& item, const auto& keep) {
		forEachChild(A.law.nodes[item.a.id], [&](const Ball& child) {
			const double rounding = kRounding * (norm(child.center) + norm(X_FA.translation) + child.r);
			keep(BallInField{child, -field.depth(X_FA * child.center) - child.r * (1 + kStretch) - rounding});
		});
	};
	return leastBound(BallInField{{0, {}, kUnbounded}, -kUnbounded}, std::min(mostOpened, kMostOpenedForClearance), expand);
}

double reachOf(const InnerSphereTree& tree)
{
	double reach = 0;
	if (!tree.surface.empty())
	{
		const SurfaceNode& root = tree.surface.surface.nodes[0];
		reach = norm(toVec3(root.center)) + double(root.radius);
	}
	const BallNode& root = tree.law.nodes[0];
	for (int k = 0; k < BallNode::kWidth; ++k)
		if (root.child[k] != BallNode::kNoChild) reach = std::max(reach, norm(Vec3{root.x[k], root.y[k], root.z[k]}) + double(root.r[k]));
	return reach;
}
}  // namespace ist
