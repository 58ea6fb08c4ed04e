// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "BulletCollision/CollisionShapes/btCompoundShape.h"

/// Whether `is` holds for the shape, or for a child of a btCompoundShape at any depth. Not installed.
template <class Predicate> bool btISTAnyPart(const btCollisionShape* shape, const Predicate& is)
{
	if (!shape) return false;
	if (is(shape)) return true;
	if (!shape->isCompound()) return false;
	const auto* compound = static_cast<const btCompoundShape*>(shape);
	for (int i = 0; i < compound->getNumChildShapes(); ++i)
		if (btISTAnyPart(compound->getChildShape(i), is)) return true;
	return false;
}
