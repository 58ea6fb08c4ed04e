// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

/// Applies two wrenches as forces of the next step, and wakes the bodies. Each wrench is in World axes about its body's centre of mass.
/// If one of them is not finite, neither is applied.
void exertExplicitly(btRigidBody& A, const ist::Wrench& onA, btRigidBody& B, const ist::Wrench& onB);

/// Pairs of bodies whose contact follows an explicit law. Bullet's own contact is switched off (setIgnoreCollisionCheck) for as long as a
/// pair is in the list. Each body must outlive this object, or be removed from it.
template <class Material, class Contact> class btExplicitPairs
{
public:
	struct Pair
	{
		btRigidBody *A, *B;
		std::shared_ptr<const ist::InnerSphereTree> treeA, treeB;
		Material material;
		Contact contact;
	};

	btExplicitPairs() = default;
	btExplicitPairs(const btExplicitPairs&) = delete;
	btExplicitPairs& operator=(const btExplicitPairs&) = delete;
	~btExplicitPairs()
	{
		for (const Pair& p : m_pairs) p.A->setIgnoreCollisionCheck(p.B, false);
	}

	/// Adds a pair. Refused: null, the same body twice, and a pair that is in the list already. Bullet keeps the contact points of bodies
	/// that already touch: clean their pairs afterwards (cleanProxyFromPairs).
	std::optional<ist::Error> add(Pair pair)
	{
		if (!pair.A || !pair.B || pair.A == pair.B) return ist::Error{"a law of contact needs two different bodies"};
		for (const Pair& p : m_pairs)
			if ((p.A == pair.A && p.B == pair.B) || (p.A == pair.B && p.B == pair.A))
				return ist::Error{"this law holds this pair of bodies already"};
		pair.A->setIgnoreCollisionCheck(pair.B, true);
		m_pairs.push_back(std::move(pair));
		return std::nullopt;
	}
	/// Removes all pairs of this body.
	void remove(btRigidBody* body)
	{
		const auto has = [body](const Pair& p) { return p.A == body || p.B == body; };
		for (const Pair& p : m_pairs)
			if (has(p)) p.A->setIgnoreCollisionCheck(p.B, false);
		m_pairs.erase(std::remove_if(m_pairs.begin(), m_pairs.end(), has), m_pairs.end());
	}
	/// All pairs, in the order of `add`.
	std::vector<Pair>& all() { return m_pairs; }
	const std::vector<Pair>& all() const { return m_pairs; }

private:
	std::vector<Pair> m_pairs;
};
