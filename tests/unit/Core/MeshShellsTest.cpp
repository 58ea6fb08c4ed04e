// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/MeshShells.h"
#include "BulletISTCollision/Core/MeshShapes.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

using namespace ist;

namespace
{
void append(Mesh& mesh, const Mesh& part)
{
	const auto base = static_cast<uint32_t>(mesh.vertices.size());
	mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
	for (const auto& t : part.triangles) mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}
}  // namespace

TEST(MeshShells, ALayerIsSettledAlikeAndAtOnceInAnyPlane)
{
	constexpr int kRow = 40;
	std::mt19937 random(6);
	std::uniform_real_distribution<double> turn(-2, 2);
	Mesh layer;
	for (int i = 0; i < kRow; ++i)
		for (int j = 0; j < kRow; ++j)
		{
			const Pose X = {rotationMatrix(quaternionFromRotationVector({turn(random), turn(random), turn(random)})), {1.5 * i, 1.5 * j, 0}};
			Mesh shell = transformed(makeTetrahedronMesh(1), X);
			// A tenth of each: inside out, with a smaller one in it, with a cavity in it.
			const int kind = (i + j) % 10;
			if (kind < 2)
			{
				append(layer, transformed(makeTetrahedronMesh(0.5), X));
				if (kind == 1)
					for (std::size_t t = layer.triangles.size() - 4; t < layer.triangles.size(); ++t) std::swap(layer.triangles[t][1], layer.triangles[t][2]);
			}
			if (kind == 2)
				for (auto& t : shell.triangles) std::swap(t[1], t[2]);
			append(layer, shell);
		}
	const double volume = massProperties(makeTetrahedronMesh(1)).volume;
	for (int plane = 0; plane < 3; ++plane)
	{
		for (const double far : {0.0, 1000.0})
		{
			Mesh mesh = translated(layer, {far, -far, far});
			const ShellVerdict verdict = settleShells(mesh);
			EXPECT_EQ(verdict.turned, kRow * kRow / 10) << plane;
			EXPECT_EQ(verdict.redundant, kRow * kRow / 10) << plane;
			EXPECT_EQ(verdict.dropped, 0) << plane;
			EXPECT_FALSE(verdict.mayOverlap) << plane;
			// A cavity takes an eighth.
			EXPECT_NEAR(massProperties(mesh).volume, kRow * kRow * volume * (1 - 0.1 / 8), 1e-9 * kRow * kRow) << plane;
			// Each with its row, and a fifth of the shells lie in others.
			EXPECT_LT(verdict.compared, 2 * kRow * kRow * kRow) << plane;
		}
		for (Vec3& v : layer.vertices) v = {v.z, v.x, v.y};
	}
}
