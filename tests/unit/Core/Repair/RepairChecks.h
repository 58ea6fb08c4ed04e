// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "tests/unit/JoinedMesh.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>

namespace ist
{
inline Mesh insideOut(Mesh mesh)
{
	for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
	return mesh;
}

/// Gives every triangle its own vertices.
inline Mesh soup(const Mesh& mesh)
{
	Mesh result;
	for (const auto& t : mesh.triangles)
	{
		const auto base = static_cast<uint32_t>(result.vertices.size());
		for (const uint32_t corner : t) result.vertices.push_back(mesh.vertices[corner]);
		result.triangles.push_back({base, base + 1, base + 2});
	}
	return result;
}

/// Checks that the repair gives a watertight mesh of this volume [m^3].
inline void expectVolume(const Mesh& mesh, double volume, double tolerance = 1e-9)
{
	const Result<RepairedMesh> repaired = repair(mesh);
	ASSERT_TRUE(repaired) << repaired.error().message;
	EXPECT_NEAR(massProperties(repaired.value().mesh).volume, volume, tolerance);
	EXPECT_EQ(repaired.value().volumeAfter, massProperties(repaired.value().mesh).volume);
	EXPECT_TRUE(inspect(repaired.value().mesh).watertight);
}

/// Checks that the repair fails with a sentence that contains `word`.
inline void expectRefused(const Mesh& mesh, const char* word, RepairMode mode = RepairMode::Auto)
{
	const Result<RepairedMesh> repaired = repair(mesh, mode);
	ASSERT_FALSE(repaired);
	EXPECT_NE(repaired.error().message.find(word), std::string::npos) << repaired.error().message;
}

inline const Mesh kBox = makeBoxMesh({1, 1, 1});
}  // namespace ist
