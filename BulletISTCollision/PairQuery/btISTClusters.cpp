// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/PairQuery/btISTClusters.h"

#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"

#include <algorithm>
#include <utility>

int btISTClusters::rootOf(int node)
{
	while (m_nodes[size_t(node)].parent != node) node = m_nodes[size_t(node)].parent = m_nodes[size_t(m_nodes[size_t(node)].parent)].parent;
	return node;
}

/// Node of the body, or -1 for one that is in no world.
int btISTClusters::add(const btCollisionObject& body, double step)
{
	const int index = body.getWorldArrayIndex();
	if (index < 0) return -1;
	if (size_t(index) >= m_nodes.size()) m_nodes.resize(size_t(index) + 1);
	Node& node = m_nodes[size_t(index)];
	if (!node.body) node = {&body, index, kNone, btISTBodyMotion::massOf(body), btISTBodyMotion::free(&body, step).twist.linear};
	return index;
}

void btISTClusters::join(int a, int b)
{
	if (!m_nodes[size_t(a)].moves()) std::swap(a, b);
	if (!m_nodes[size_t(a)].moves()) return;
	Node& root = m_nodes[size_t(rootOf(a))];
	if (m_nodes[size_t(b)].moves())
	{
		// The root is the same for any order of the pairs.
		Node& other = m_nodes[size_t(rootOf(b))];
		const int anchor = std::min(root.anchor, other.anchor);
		root.parent = other.parent = std::min(root.parent, other.parent);
		m_nodes[size_t(root.parent)].anchor = anchor;
	}
	else root.anchor = std::min(root.anchor, b);
}

void btISTClusters::beginStep(const btISTContactStore& store, double step)
{
	if (store.step() == m_step) return;
	m_step = store.step();
	for (Node& node : m_nodes) node.body = nullptr;
	for (const btISTContact* contact : store.contacts())
	{
		if (contact->stamp == 0 || contact->stamp + 1 != m_step) continue;  // 0: not evaluated yet, it has no bodies
		const int a = add(*contact->bodyA, step), b = add(*contact->bodyB, step);
		if (a >= 0 && b >= 0) join(a, b);
	}
	// This loop meets a root before the rest of its cluster, since the root has the least index.
	for (size_t i = 0; i < m_nodes.size(); ++i)
	{
		const Node& node = m_nodes[i];
		if (!node.body || !node.moves()) continue;
		Node& root = m_nodes[size_t(rootOf(int(i)))];
		if (root.anchor != kNone) root.velocity = m_nodes[size_t(root.anchor)].velocity;
		else if (&root != &node)
		{
			root.mass += node.mass;
			root.velocity += (node.mass / root.mass) * (node.velocity - root.velocity);
		}
	}
}

const ist::Vec3* btISTClusters::velocityOf(const btCollisionObject& body)
{
	const int index = body.getWorldArrayIndex();
	if (index < 0 || size_t(index) >= m_nodes.size()) return nullptr;
	const Node& node = m_nodes[size_t(index)];
	return node.body == &body && node.moves() ? &m_nodes[size_t(rootOf(index))].velocity : nullptr;
}
