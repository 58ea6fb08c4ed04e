// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletShapeParts.h"

#include "BulletISTCollision/Registry/btISTShapeField.h"

#include <utility>

namespace devicebridge
{
ShapeModel ShapeModel::of(const btISTRegistry& registry, const btCollisionShape& shape)
{
	ShapeModel model;
	model.tree = registry.find(&shape);
	if (model.tree || registry.isAttached(&shape)) return model;
	const btISTShapeField field(&shape);
	model.field = field.any();
	model.X_SP = field.X_SF();
	return model;
}

ToolPart toolPartOf(std::shared_ptr<const ist::InnerSphereTree> tree)
{
	ToolPart part;
	part.center = tree->origin;
	part.radius = norm(componentMax(tree->box.upper, -tree->box.lower));
	part.tree = std::move(tree);
	return part;
}

std::vector<ToolPart> toolPartsOf(const btISTRegistry& registry, const btCollisionShape& shape)
{
	std::vector<ToolPart> parts;
	forEachShapePart(registry, shape, [&](const btCollisionShape& child, const ist::Pose& X_TS) {
		const ShapeModel model = ShapeModel::of(registry, child);
		if (!model.isOfTool()) return;
		ToolPart part;
		if (model.tree) part = toolPartOf(model.tree);
		else
		{
			btVector3 low, high;
			child.getAabb(btTransform::getIdentity(), low, high);
			part.field = model.field;
			part.center = 0.5 * (toVec3(low) + toVec3(high));
			part.radius = 0.5 * norm(toVec3(high) - toVec3(low));
		}
		part.center = X_TS * part.center;
		part.X_TP = X_TS * model.X_SP;
		parts.push_back(std::move(part));
	});
	return parts;
}

std::vector<UnfeltToolPart> unfeltPartsOf(const btISTRegistry& registry, const btCollisionShape& shape)
{
	std::vector<UnfeltToolPart> unfelt;
	int index = 0;
	forEachShapePart(registry, shape, [&](const btCollisionShape& child, const ist::Pose&) {
		const ShapeModel model = ShapeModel::of(registry, child);
		if (!model.isOfTool()) unfelt.push_back({index, child.getName(), ShapeModel::wasScaled(registry, child), model.isKnown()});
		++index;
	});
	return unfelt;
}
}  // namespace devicebridge
