// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Registry/btISTRegistry.h"

#include <vector>

class btCollisionObject;
class btCollisionShape;
class btDiscreteDynamicsWorld;

/// Two bodies of which one has a tree, and how many parts a step had to have so that neither travels more than a quarter of the thinner
/// one's thickness in one of them.
struct btISTFastPair
{
	const btCollisionObject* first = nullptr;
	const btCollisionObject* second = nullptr;
	int substeps = 1;
};

/// How finely a step must be divided so that no body with a tree is passed through between two looks at it.
///
/// Thickness: of a tree 2 V / S, which for a plate is its thickness, for a ball two thirds of its radius; of another bounded shape the
/// shortest side of its box; of a compound that of its thinnest child. A part thinner than a quarter of the mean that 2 V / S is can
/// still be missed. Travel: relative speed of the centres and what both spins move the surfaces, with the gravity of one step.
/// No allocation once as many pairs have been found before.
class btISTSubsteps
{
public:
	/// Substeps for the next `seconds`, at most `most`; all pairs that need more than one are in `pairs` afterwards. Forces other than
	/// gravity are not foreseen. Between steps only. O(bodies), and a look into the broad phase for each fast one.
	int plan(btDiscreteDynamicsWorld& world, const btISTRegistry& registry, double seconds, int most);
	const std::vector<btISTFastPair>& pairs() const { return m_pairs; }

	/// [m]; infinite for unbounded shapes and for surfaces without an inside.
	static double thickness(const btCollisionShape* shape, const btISTRegistry& registry);

private:
	void addPair(const btCollisionObject* a, const btCollisionObject* b, const btISTRegistry& registry, double seconds, double gravity);

	std::vector<btISTFastPair> m_pairs;
	std::vector<const btCollisionObject*> m_near;
};
