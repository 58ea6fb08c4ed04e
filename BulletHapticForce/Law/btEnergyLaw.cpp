// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btEnergyLaw.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include <cmath>

namespace
{
ist::QueryCapacity capacityOf(int pairs)
{
	ist::QueryCapacity capacity;
	capacity.pairs = std::max(pairs, 1);
	return capacity;
}

ist::Vec3 centerOf(const btRigidBody& body) { return toVec3(body.getWorldTransform().getOrigin()); }
}  // namespace

btEnergyLaw::btEnergyLaw(int pairCapacity) : m_workspace(capacityOf(pairCapacity)) {}

std::optional<ist::Error> btEnergyLaw::add(btRigidBody* A, std::shared_ptr<const ist::InnerSphereTree> treeA, btRigidBody* B,
	std::shared_ptr<const ist::InnerSphereTree> treeB, const ist::PressurePair& material)
{
	if (!treeA || !treeB || treeA->law.empty() || treeB->law.empty()) return ist::Error{"the energy law needs a tree for each body"};
	for (const double constant : {material.stiffness, material.weightA, material.weightB})
		if (!std::isfinite(constant) || constant < 0) return ist::Error{"stiffness and weights must be finite numbers, 0 or more"};
	if (!(material.weightA + material.weightB > 0)) return ist::Error{"the field of one body at least must have a weight"};
	return m_pairs.add({A, B, std::move(treeA), std::move(treeB), material, {}});
}

void btEnergyLaw::evaluate(Pairs::Pair& pair)
{
	btEnergyContact& contact = pair.contact;
	contact = btEnergyContact();
	const ist::Pose X_WA = toRigidPose(pair.A->getWorldTransform()), X_AB = ist::inverse(X_WA) * toRigidPose(pair.B->getWorldTransform());
	ist::QueryOptions options;
	options.stiffness = options.patches = false;
	options.sortPairs = options.listMeetingBounds = true;
	const ist::OverlapResult overlap = ist::queryOverlap(*pair.treeA, *pair.treeB, X_AB, m_workspace, options);
	contact.complete = overlap.status == ist::QueryStatus::Ok && overlap.pairListComplete;
	if (!contact.complete) return;
	contact.pairs = overlap.pairCount;
	const ist::PairLawResult law = ist::energyLaw(*pair.treeA, *pair.treeB, X_AB, overlap.pairs, overlap.pairCount, pair.material);
	contact.energy = law.energy;
	const ist::Vec3 origin = X_WA * pair.treeA->origin, force = X_WA.rotation * law.wrench.force,
					torque = X_WA.rotation * law.wrench.torque;
	contact.onA = {force, torque + cross(origin - centerOf(*pair.A), force)};
	contact.onB = {-force, -torque - cross(origin - centerOf(*pair.B), force)};
}

void btEnergyLaw::apply()
{
	for (Pairs::Pair& pair : m_pairs.all())
	{
		evaluate(pair);
		m_refused += !pair.contact.complete;
		if (pair.contact.pairs > 0) exertExplicitly(*pair.A, pair.contact.onA, *pair.B, pair.contact.onB);
	}
}
