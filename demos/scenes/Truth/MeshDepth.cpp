// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/MeshDepth.h"

#include <algorithm>

using namespace ist;

namespace scenes
{
namespace
{
/// Depth below the nearest side of a box, negative outside.
double depthIn(const Box& box, const Vec3& p)
{
	const Vec3 a = p - box.lower, b = box.upper - p;
	return std::min({a.x, a.y, a.z, b.x, b.y, b.z});
}
}  // namespace

MeshDepth::MeshDepth(const Mesh& mesh) : m_distance(mesh), m_box(bounds(mesh))
{
	for (const Vec3& p : mesh.vertices) m_reach = std::max(m_reach, norm(p));
}

double MeshDepth::deepest(const Mesh& other, const Pose& X) const
{
	double deepest = 0;
	for (const Vec3& vertex : other.vertices)
	{
		const Vec3 p = X * vertex;
		// A point is never deeper in a body than in the body's box.
		if (depthIn(m_box, p) > deepest) deepest = std::max(deepest, -m_distance.signedDistance(p));
	}
	return deepest;
}

double deepestEither(const MeshDepth& a, const Pose& X_Wa, const MeshDepth& b, const Pose& X_Wb)
{
	if (distance(X_Wa.translation, X_Wb.translation) > a.reach() + b.reach()) return 0;
	const Pose X_ab = inverse(X_Wa) * X_Wb;
	return std::max(a.deepest(b.mesh(), X_ab), b.deepest(a.mesh(), inverse(X_ab)));
}

double deepestInBox(const Vec3& half, const Pose& X_WB, const Mesh& mesh, const Pose& X_WM)
{
	const Box box{-half, half};
	const Pose X = inverse(X_WB) * X_WM;
	double deepest = 0;
	for (const Vec3& vertex : mesh.vertices) deepest = std::max(deepest, depthIn(box, X * vertex));
	return deepest;
}
}  // namespace scenes
