// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Registry/btPrecisionGuard.h"

/// Settings of btISTWorld::debugDraw: each chooses a kind of lines. A game that never calls debugDraw pays nothing. The call itself
/// allocates no memory; the game's btIDebugDraw may.
struct btISTDebugDraw
{
	/// Each patch as a ring of its friction radius, with an arrow of its elastic force on the body that moves, and text of force and depth.
	bool patches = true;
	/// Each volumetric pair that touches, as lines from its movable bodies to the contact. Their colour is the depth as a share of the
	/// thinner body's thickness: green at none, yellow at a twentieth, red from a tenth on, where a body may be pushed through
	/// (btISTContact::isDeep).
	bool pairs = true;
	/// Contact points of Bullet's own algorithms, in grey.
	bool stock = true;
	bool text = true;
	/// Balls of the bodies that have a tree: -2 none, -1 the packed spheres, 0 the leaves, 1 and more the levels, as far as the tree has
	/// them.
	int balls = -2;
	int mostBalls = 500;             ///< largest number of balls of a shape; of more, every n-th is drawn
	double metresPerNewton = 0.005;  ///< length of the arrows
};
