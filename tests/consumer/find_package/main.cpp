// SPDX-License-Identifier: Zlib
// A user's first program: two boxes, one of a mesh file, packed, one pressed 1 cm into the other. Flat contact: force = k * volume.
#include <BulletISTCollision/Core/Build/TreeBuilder.h>
#include <BulletISTCollision/Core/Force/PressureField.h>
#include <BulletISTCollision/Core/Import/MeshImport.h>
#include <BulletISTCollision/Core/Mesh/MeshShapes.h>

#include <cmath>
#include <cstdio>
#include <fstream>

/// A box that a file describes: the program bullethaptics-import of the installation reads it.
ist::Result<ist::Mesh> boxOfFile()
{
	const ist::Mesh box = ist::makeBoxMesh({0.1, 0.1, 0.1});
	std::ofstream file("box.obj");
	for (const ist::Vec3& v : box.vertices) file << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
	for (const auto& t : box.triangles) file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
	file.close();
	return ist::importMesh("box.obj");
}

int main()
{
	const ist::Result<ist::Mesh> mesh = boxOfFile();
	if (!mesh)
	{
		std::fprintf(stderr, "%s\n", mesh.error().message.c_str());
		return 1;
	}
	ist::BuildOptions options;
	options.maxSpheres = 2000;
	const ist::Result<ist::InnerSphereTree> box = ist::buildTree(mesh.value(), options);
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
