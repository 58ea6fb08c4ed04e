// SPDX-License-Identifier: Zlib
#include "DeviceBridge/BulletHeatMap.h"

#include "BulletISTCollision/btISTConversion.h"

using namespace ist;

namespace devicebridge
{
std::unique_ptr<HeatMap> makeHeatMap(const HandModel& hand, Mesh object)
{
	auto map = std::make_unique<HeatMap>(std::move(object));
	for (int i = 0; i < kHandParts; ++i)
		map->addPart(handPartName(i, hand.shape.left), handPartId(i, hand.shape.left), hand.parts[static_cast<std::size_t>(i)].mesh);
	return map;
}

double addTouches(HeatMap& map, const BulletHand& hand, const btISTContactStore& contacts, const btRigidBody& object, const Pose& X_BM, double h, double seconds,
				  int only) noexcept
{
	double sum = 0;
	const Pose X_WM = toPose(object.getWorldTransform()) * X_BM;
	for (const btISTContact* contact : contacts.contacts())
	{
		if (!touchedInLastStep(contacts, *contact)) continue;
		if (contact->bodyA != &object && contact->bodyB != &object) continue;
		const int part = hand.partOf(contact->bodyA == &object ? contact->bodyB : contact->bodyA);
		if (part < 0 || (only >= 0 && part != only)) continue;
		Vec3 pressed;
		for (int i = 0; i < contact->patchCount; ++i)
		{
			const Vec3 normal = contact->X_WA.rotation * normalized(contact->patches[i].areaVector);
			pressed += dot(contact->impulses[i].force, normal) / h * normal;
		}
		const Vec3 point = contact->X_WA * (contact->treeA->origin + contact->total.firstMoment / contact->total.volume);
		map.add(part, {inverse(X_WM) * toPose(hand.body(part).getWorldTransform()), norm(pressed), inverse(X_WM) * point, seconds});
		sum += norm(pressed);
	}
	return sum;
}
}  // namespace devicebridge
