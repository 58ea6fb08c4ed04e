// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <vector>

#include "BulletISTCollision/Registry/btISTConversion.h"
#include "BulletISTCollision/Registry/btISTRegistry.h"
#include "DeviceBridge/Bullet/BulletToolContacts.h"

#include "BulletCollision/CollisionShapes/btCompoundShape.h"

// A body's shape has one or more parts, and each part has its own model in a query. The parts are the shape itself, or the children of a
// compound at any depth. This header is not installed.

namespace devicebridge
{
/// Calls `visit(const btCollisionShape& part, const ist::Pose& X_BS)` for each part. A compound that has a tree is one part. X_BS: pose of
/// the part's shape in the body.
template <class Visit>
void forEachShapePart(const btISTRegistry& registry, const btCollisionShape& shape, const Visit& visit, const ist::Pose& X_BS = {})
{
	if (!shape.isCompound() || registry.isAttached(&shape)) return visit(shape, X_BS);
	const auto& compound = static_cast<const btCompoundShape&>(shape);
	for (int i = 0; i < compound.getNumChildShapes(); ++i)
		if (const btCollisionShape* child = compound.getChildShape(i))
			forEachShapePart(registry, *child, visit, X_BS * toRigidPose(compound.getChildTransform(i)));
}

/// What represents a part in a query: its tree, its closed form, or nothing.
struct ShapeModel
{
	std::shared_ptr<const ist::InnerSphereTree> tree;
	ist::AnyField field;
	ist::Pose X_SP;  ///< frame P of tree or closed form in the shape's

	/// Finds the model of a shape. A tree is for one scaling: if the shape was scaled after its tree was attached, it has no model, and
	/// btISTCollisionAlgorithm uses none either.
	static ShapeModel of(const btISTRegistry& registry, const btCollisionShape& shape);
	/// Whether the shape has a tree that does not fit, because the shape was scaled after the tree was attached.
	static bool wasScaled(const btISTRegistry& registry, const btCollisionShape& shape)
	{
		return registry.isAttached(&shape) && !registry.find(&shape);
	}
	bool isKnown() const { return tree || ist::fieldIn(field); }
	/// Whether it can be a part of a tool; a half-space cannot.
	bool isOfTool() const { return tree || (ist::fieldIn(field) && !std::holds_alternative<ist::HalfSpaceField>(field)); }
};

/// The only part of a tool with this tree.
ToolPart toolPartOf(std::shared_ptr<const ist::InnerSphereTree> tree);
/// The parts of a tool's shape that have a model (ShapeModel::isOfTool).
std::vector<ToolPart> toolPartsOf(const btISTRegistry& registry, const btCollisionShape& shape);
/// The other parts.
std::vector<UnfeltToolPart> unfeltPartsOf(const btISTRegistry& registry, const btCollisionShape& shape);
}  // namespace devicebridge
