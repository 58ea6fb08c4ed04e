// SPDX-License-Identifier: Zlib
#include "demos/scenes/Bodies/FieldBodies.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <cmath>
#include <utility>

using namespace ist;

namespace scenes
{
namespace
{
template <class Field> FieldBody bodyOf(const char* name, Field field, Mesh mesh)
{
	const double scale = std::cbrt(field.volume() / massProperties(mesh).volume);
	for (Vec3& p : mesh.vertices) p *= scale;
	return {name, std::make_unique<Field>(field), std::move(mesh)};
}
}  // namespace

std::vector<FieldBody> makeFieldBodies(double size)
{
	constexpr int kSegments = 160, kSubdivisions = 5;
	const double s = size;
	std::vector<FieldBody> bodies;
	bodies.push_back(bodyOf("box", BoxField({0.4 * s, 0.3 * s, 0.25 * s}), makeBoxMesh({0.4 * s, 0.3 * s, 0.25 * s})));
	bodies.push_back(bodyOf("plate", BoxField({0.5 * s, 0.5 * s, 0.02 * s}), makeBoxMesh({0.5 * s, 0.5 * s, 0.02 * s})));
	bodies.push_back(bodyOf("sphere", SphereField(0.3 * s), makeSphereMesh(0.3 * s, kSubdivisions)));
	bodies.push_back(bodyOf("small sphere", SphereField(0.06 * s), makeSphereMesh(0.06 * s, kSubdivisions)));
	bodies.push_back(bodyOf("capsule", CapsuleField(0.15 * s, 0.3 * s), makeCapsuleMesh(0.15 * s, 0.3 * s, kSegments)));
	bodies.push_back(bodyOf("cylinder", CylinderField(0.25 * s, 0.3 * s), makeCylinderMesh(0.25 * s, 0.3 * s, kSegments)));
	bodies.push_back(bodyOf("cone", ConeField(0.3 * s, 0.7 * s), makeConeMesh(0.3 * s, 0.7 * s, kSegments)));
	return bodies;
}
}  // namespace scenes
