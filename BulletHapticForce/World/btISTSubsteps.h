// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Registry/btISTRegistry.h"

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"

#include <cstddef>
#include <cstdint>
#include <vector>

class btCollisionShape;
class btDiscreteDynamicsWorld;

/// Two bodies, of which at least one has a tree, that move fast relative to each other. `substeps` is the number of parts that a step
/// needs so that the pair travels at most a quarter of the thinner body's thickness in one part.
struct btISTFastPair
{
	const btCollisionObject* first = nullptr;
	const btCollisionObject* second = nullptr;
	int substeps = 1;
};

/// Computes into how many parts a step must be divided so that no body passes through another, of which one has a tree, between two
/// queries.
///
/// The thickness of a tree is 2 V / S: the thickness of a plate, and two thirds of the radius of a ball. For another bounded shape it is
/// the shortest side of its box, and for a compound that of its thinnest child. A part of a body that is thinner than a quarter of the
/// mean thickness 2 V / S can still be missed.
///
/// The travel is the relative speed of the centres plus the speed at which both spins move the surfaces, with the gravity of one step.
/// Allocates nothing once as many bodies and pairs have been found before.
class btISTSubsteps
{
public:
	/// Returns the number of parts for the next step of `seconds`, at most `most`. All pairs that need more than one part are in `pairs`
	/// afterwards. Of the forces only gravity is predicted. Call it between steps only. Cost: O(bodies), a search of the broad phase for
	/// each fast body, and O(F log F) for the F bodies that these searches find.
	int plan(btDiscreteDynamicsWorld& world, const btISTRegistry& registry, double seconds, int most);
	/// Each fast pair once, in the order of the bodies in the world.
	const std::vector<btISTFastPair>& pairs() const { return m_pairs; }
	/// Number of comparisons of bodies in the last plan. It measures the cost of finding each pair once, independent of a clock.
	uint64_t comparisons() const { return m_comparisons; }

	/// Thickness of a shape [m]; infinite for unbounded shapes and for surfaces without an inside.
	static double thickness(const btCollisionShape* shape, const btISTRegistry& registry);

private:
	/// Properties of an object that its pairs need, computed once in a plan. Its index in `m_bodies` is its index in the world.
	struct Body
	{
		double thickness = 0;
		bool hasTree = false;
		size_t firstPair = 0, pairsEnd = 0;  // range of the pairs of which this body is the first, in the order of their second body
	};
	/// Fills `m_bodies`. Returns the thickness of the thinnest tree; infinite where no body has one.
	double measureBodies(const btCollisionObjectArray& objects, const btISTRegistry& registry);
	void findNear(btDiscreteDynamicsWorld& world, int body, double travel, double seconds);
	bool isKnown(int first, int second);
	void addPair(const btCollisionObjectArray& objects, int first, int second, double seconds, double gravity);

	std::vector<btISTFastPair> m_pairs;
	std::vector<Body> m_bodies;
	std::vector<int> m_near;  // indices in the world
	uint64_t m_comparisons = 0;
};
