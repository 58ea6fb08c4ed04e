// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Registry/btISTRegistry.h"

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"

#include <cstddef>
#include <cstdint>
#include <vector>

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
/// No allocation once as many bodies and pairs have been found before.
class btISTSubsteps
{
public:
	/// Substeps for the next `seconds`, at most `most`; all pairs that need more than one are in `pairs` afterwards. Forces other than
	/// gravity are not foreseen. Between steps only. Cost: O(bodies), a search of the broad phase for each fast body, and O(F log F) for
	/// the F bodies that these searches find.
	int plan(btDiscreteDynamicsWorld& world, const btISTRegistry& registry, double seconds, int most);
	/// Each pair once, in the order that the world has its bodies in.
	const std::vector<btISTFastPair>& pairs() const { return m_pairs; }
	/// Comparisons of bodies in the last plan: what finding each pair once cost, without a clock.
	uint64_t comparisons() const { return m_comparisons; }

	/// [m]; infinite for unbounded shapes and for surfaces without an inside.
	static double thickness(const btCollisionShape* shape, const btISTRegistry& registry);

private:
	/// What pairs ask of an object, once in a plan. Its place in `m_bodies` is that in the world.
	struct Body
	{
		double thickness = 0;
		bool hasTree = false;
		size_t firstPair = 0, pairsEnd = 0;  // pairs of which this body is the first, in the order of their second
	};
	/// Thickness of the thinnest tree, infinite where no body has one.
	double measureBodies(const btCollisionObjectArray& objects, const btISTRegistry& registry);
	void findNear(btDiscreteDynamicsWorld& world, int body, double travel, double seconds);
	bool isKnown(int first, int second);
	void addPair(const btCollisionObjectArray& objects, int first, int second, double seconds, double gravity);

	std::vector<btISTFastPair> m_pairs;
	std::vector<Body> m_bodies;
	std::vector<int> m_near;  // places in the world
	uint64_t m_comparisons = 0;
};
