// SPDX-License-Identifier: Zlib
#include "demos/browser/catalog/KeptCheck.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Registry/btISTShapeField.h"

#include "BulletCollision/CollisionDispatch/btCollisionObject.h"

#include <algorithm>

using namespace ist;

namespace browser
{
namespace
{
/// Repeats the query of a pair of bodies that are not compounds.
OverlapResult askAgain(const btISTContact& contact, QueryWorkspace& workspace)
{
	if (contact.treeB) return queryOverlap(*contact.treeA, *contact.treeB, contact.X_AB, workspace);
	const btISTShapeField field(contact.bodyB->getCollisionShape());
	return queryField(*contact.treeA, *field.field(), contact.X_AB * field.X_SF(), workspace);
}
}  // namespace

void KeptCheck::look(btISTWorld& world)
{
	btISTContactStore& store = world.contacts();
	for (const btISTContact* contact : store.contacts())
	{
		if (contact->stamp + 1 != store.step() || contact->use == btISTCachedResult::Ask) continue;
		++kept;
		const OverlapResult truth = askAgain(*contact, m_workspace);
		if (contact->patchCount == 0)
		{
			missed += truth.total.volume > 0;
			continue;
		}
		const btISTPairConstants& c = contact->constants;
		const PressurePair pair{c.k, c.weightA, c.weightB};
		const Vec3 force = pressureWrench(truth.total, pair).force;
		errors.push_back(
			distance(pressureWrench(contact->total, pair).force, force) / std::max(norm(force), btISTCachedResult::floorForce(*contact)));
		changed += contact->use == btISTCachedResult::Still && !(contact->total.volume == truth.total.volume && errors.back() == 0);
	}
}

double KeptCheck::share(double of)
{
	if (errors.empty()) return 0;
	const auto at = errors.begin() + long(of * double(errors.size() - 1));
	std::nth_element(errors.begin(), at, errors.end());
	return *at;
}
}  // namespace browser
