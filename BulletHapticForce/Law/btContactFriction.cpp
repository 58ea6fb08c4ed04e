// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btContactFriction.h"

namespace
{
/// Sets one wrench of a ball.
void setWrench(btFrictionBall& ball, int index, const ist::Vec3& force, const ist::Vec3& torque)
{
	double* out = ball.E + 6 * index;
	for (int i = 0; i < 3; ++i)
	{
		out[i] = force[i];
		out[3 + i] = torque[i];
	}
}
}  // namespace

int btContactFriction::balls(const btContactPatch& patch, btFrictionBall* out) const
{
	const ist::Vec3& n = patch.normal;
	ist::Vec3 t1, t2;
	ist::completeFrame(n, t1, t2);
	int count = 0;
	if (sliding > 0)
	{
		btFrictionBall& ball = out[count++];
		ball.coefficient = sliding * patch.frictionFactor;
		setWrench(ball, 0, t1, {});
		setWrench(ball, 1, t2, {});
		setWrench(ball, 2, {}, patch.frictionRadius * n);
	}
	if (rolling > 0 || spinning > 0)
	{
		btFrictionBall& ball = out[count++];
		ball.coefficient = 1;
		setWrench(ball, 0, {}, rolling * t1);
		setWrench(ball, 1, {}, rolling * t2);
		setWrench(ball, 2, {}, spinning * n);
	}
	return count;
}
