// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/PrincipalMesh.h"

#include "LinearMath/btMatrix3x3.h"

using namespace ist;

namespace scenes
{
PrincipalMesh inPrincipalFrame(const Mesh& mesh)
{
	const MassProperties mass = massProperties(mesh);
	// The inertia is scaled to order 1, so that Bullet's absolute thresholds do not matter.
	const double scale = 3 / (mass.inertia.m[0][0] + mass.inertia.m[1][1] + mass.inertia.m[2][2]);
	btMatrix3x3 inertia, axes;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) inertia[i][j] = btScalar(scale * mass.inertia.m[i][j]);
	inertia.diagonalize(axes, btScalar(1e-6), 50);
	Mat3 R;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) R.m[i][j] = double(axes[i][j]);
	const Pose X_MP{rotationMatrix(quaternion(R)), mass.centerOfMass};
	return {transformed(mesh, inverse(X_MP)), X_MP};
}
}  // namespace scenes
