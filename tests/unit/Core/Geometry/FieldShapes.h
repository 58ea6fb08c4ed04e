// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace ist
{
/// A body in closed form and a fine mesh of it.
struct FieldShape
{
	std::string name;
	std::unique_ptr<AnalyticField> field;
	Mesh mesh;
};

inline std::vector<FieldShape> fieldShapes()
{
	constexpr int kSegments = 192;
	std::vector<FieldShape> shapes;
	shapes.push_back({"box", std::make_unique<BoxField>(Vec3{0.7, 0.5, 0.4}), makeBoxMesh({0.7, 0.5, 0.4})});
	shapes.push_back({"sphere", std::make_unique<SphereField>(0.6), makeSphereMesh(0.6, 5)});
	shapes.push_back({"capsule", std::make_unique<CapsuleField>(0.35, 0.4), makeCapsuleMesh(0.35, 0.4, kSegments)});
	shapes.push_back({"cylinder", std::make_unique<CylinderField>(0.5, 0.5), makeCylinderMesh(0.5, 0.5, kSegments)});
	shapes.push_back({"cone", std::make_unique<ConeField>(0.6, 1.2), makeConeMesh(0.6, 1.2, kSegments)});
	return shapes;
}
}  // namespace ist
