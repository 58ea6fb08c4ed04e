// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btExplicitPairs.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

void exertExplicitly(btRigidBody& A, const ist::Wrench& onA, btRigidBody& B, const ist::Wrench& onB)
{
	if (!ist::isFinite(onA) || !ist::isFinite(onB)) return;
	const auto exert = [](btRigidBody& body, const ist::Wrench& wrench) {
		body.activate();
		body.applyCentralForce(toBullet(wrench.force));
		body.applyTorque(toBullet(wrench.torque));
	};
	exert(A, onA);
	exert(B, onB);
}
