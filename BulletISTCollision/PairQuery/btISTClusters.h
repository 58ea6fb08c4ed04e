// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"

#include <cmath>
#include <limits>
#include <vector>

/// The clusters of bodies that are near each other, and the velocity to which contact may bring a body of one within a step. The lowest
/// body of a stack that falls, or a link of a chain that is caught, stops its neighbours in the same step, which their own motion does not
/// foretell. Not installed.
class btISTClusters
{
public:
	/// Reads the pairs of the last step, and the motion of their bodies in one of `step` [s]. Does nothing if it was called in this step of
	/// the store. The order of the pairs does not matter. Allocates nothing after the largest world has been seen.
	void beginStep(const btISTContactStore& store, double step);
	/// Velocity of the cluster of this body [m/s, World]: that of a body in it which the solver cannot move, else that of its centre of
	/// mass. Null for a body that the solver cannot move, and for one that was near no other in the last step.
	const ist::Vec3* velocityOf(const btCollisionObject& body);

private:
	static constexpr int kNone = std::numeric_limits<int>::max();
	struct Node
	{
		const btCollisionObject* body = nullptr;
		int parent = 0;
		int anchor = kNone;  // of a root: least index of a body at the cluster that the solver cannot move
		double mass = 0;     // of a root: of the cluster, as far as it was met
		ist::Vec3 velocity;  // of a root: of the cluster
		bool moves() const { return std::isfinite(mass); }
	};
	int rootOf(int node);
	int add(const btCollisionObject& body, double step);
	void join(int a, int b);

	std::vector<Node> m_nodes;  // by index in the world
	uint64_t m_step = 0;
};
