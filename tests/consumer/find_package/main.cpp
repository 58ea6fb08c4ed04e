// SPDX-License-Identifier: Zlib
// A user's first program: two boxes, packed, one pressed 1 cm into the other. Flat contact: force = k * volume.
#include <BulletISTCollision/Core/Build/TreeBuilder.h>
#include <BulletISTCollision/Core/Force/PressureField.h>
#include <BulletISTCollision/Core/Mesh/MeshShapes.h>

#include <cmath>
#include <cstdio>

int main()
{
	ist::BuildOptions options;
	options.maxSpheres = 2000;
	const ist::Result<ist::InnerSphereTree> box = ist::buildTree(ist::makeBoxMesh({0.1, 0.1, 0.1}), options);
	if (!box)
	{
		std::fprintf(stderr, "%s\n", box.error().message.c_str());
		return 1;
	}
	ist::QueryWorkspace workspace;
	const ist::Pose X_AB{{}, {0, 0, -0.19}};  // B below A
	const ist::OverlapResult overlap = ist::queryOverlap(box.value(), box.value(), X_AB, workspace);
	const double k = 1e6;
	const ist::Wrench onA = ist::pressureWrench(overlap.total, {k, 0.5, 0.5});
	const double expected = 0.2 * 0.2 * 0.01;
	std::printf(
		"volume %g m^3 (exact %g), force on A (%g, %g, %g) N\n", overlap.total.volume, expected, onA.force.x, onA.force.y, onA.force.z);
	return std::fabs(overlap.total.volume / expected - 1) < 0.1 && onA.force.z > 0 ? 0 : 1;
}
