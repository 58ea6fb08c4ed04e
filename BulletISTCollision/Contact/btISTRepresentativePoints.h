// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "BulletCollision/NarrowPhaseCollision/btPersistentManifold.h"

class btManifoldResult;
struct btCollisionObjectWrapper;

/// A point that represents a share of the contact. World axes; `normal` points from B to A.
struct btISTRepresentativePoint
{
	ist::Vec3 position, normal;
	double force = 0, stiffness = 0;  // [N], [N/m]
	double depth() const { return force / stiffness; }
};

/// The points of a volumetric contact that Bullet's own solver and contact tests see. There are at most as many as a manifold holds.
struct btISTRepresentativePoints
{
	explicit btISTRepresentativePoints(const btISTContact& contact);

	/// Writes the points into a manifold whose bodies are those of the wrappers, in this order. Points that persist keep their slots.
	void write(btPersistentManifold& manifold, double dissipation, const btCollisionObjectWrapper* wrapA,
		const btCollisionObjectWrapper* wrapB) const;
	/// Reports the points to a contact test, which collects points of its own.
	void report(btManifoldResult& out) const;

	btISTRepresentativePoint point[MANIFOLD_CACHE_SIZE];
	int count = 0;
};
