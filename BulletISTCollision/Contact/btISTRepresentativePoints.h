// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "BulletCollision/NarrowPhaseCollision/btPersistentManifold.h"

class btManifoldResult;
struct btCollisionObjectWrapper;

/// One point that stands for a share of the contact: World axes; `normal` points from B to A.
struct btISTRepresentativePoint
{
	ist::Vec3 position, normal;
	double force = 0, stiffness = 0;  // [N], [N/m]
	double depth() const { return force / stiffness; }
};

/// At most as many as one of Bullet's manifolds holds: what its own solver and contact tests see of a volumetric contact.
struct btISTRepresentativePoints
{
	explicit btISTRepresentativePoints(const btISTContact& contact);

	/// Into a manifold whose bodies are those of the wrappers, in this order. Keeps the points that are still there in their slots.
	void write(btPersistentManifold& manifold, double dissipation, const btCollisionObjectWrapper* wrapA,
		const btCollisionObjectWrapper* wrapB) const;
	/// To a contact test, which collects points of its own.
	void report(btManifoldResult& out) const;

	btISTRepresentativePoint point[MANIFOLD_CACHE_SIZE];
	int count = 0;
};
