// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/Foundation.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace ist
{
namespace
{
/// Cosine above which a normal is that of a flat body's side.
constexpr double kAlongNormal = 0.999;
/// Error of a depth that counts as exact, as a share of the mean depth of a contact.
constexpr double kExactDepth = 0.02;
/// Share of the area of a contact on a foundation where the foundation may be something else.
constexpr double kFewAmiss = 0.02;
/// Two fields press along the same normal where the normals of the faces are shorter along it by this share in the mean: the force along
/// them differs by about as much. Twice as much, and they do not.
constexpr double kAlike = 0.0025;
/// The gradient and the Hessian of a plane's depth may be off by this.
constexpr double kRounding = 1e-7;
}  // namespace

Foundation::Foundation(const BodySurface& body, const BodySurface& other, const FaceList& onOther, const FaceList& own)
{
	if (onOther.count == 0) return;
	const ContactFace* widest = onOther.faces.data();
	double area = 0, depth = 0, amiss = 0, spread = 0;
	for (size_t i = 0; i < onOther.count; ++i)
	{
		const ContactFace& face = onOther.faces[i];
		area += face.area;
		depth += face.depth;
		if (face.area > widest->area) widest = &face;
	}
	if (!(depth > 0)) return;
	const Vec3 g = widest->gradient;
	const double leastError = kExactDepth * depth / area;
	for (size_t i = 0; i < onOther.count; ++i)
	{
		const ContactFace& face = onOther.faces[i];
		const DepthCell& cell = body.field.cells[face.cell];
		const bool isLinear = squaredNorm(face.gradient - g) < kRounding * kRounding &&
			std::all_of(std::begin(cell.hessian), std::end(cell.hessian), [&](float h) { return std::fabs(h) * cell.radius < kRounding; });
		amiss += face.area * (isLinear ? std::clamp(double(cell.error) / leastError - 1, 0.0, 1.0) : 1);
		if (amiss >= kFewAmiss * area) return;
		spread += face.area - dot(face.areaNormal, g);
	}
	double ownArea = 0, error = 0;  // of the other's depth at those faces, times their area
	for (size_t i = 0; i < own.count; ++i)
	{
		const ContactFace& face = own.faces[i];
		ownArea += face.area;
		error += face.area * double(other.field.cells[face.cell].error);
		if (dot(face.areaNormal, g) > -kAlongNormal * norm(face.areaNormal)) amiss += face.area;
	}
	const double errs = ownArea > 0 ? std::clamp(error / (leastError * ownArea) - 1, 0.0, 1.0) : 1;
	const double flat = errs * std::clamp(1 - amiss / (kFewAmiss * area), 0.0, 1.0);
	volume = amiss == 0 ? 1 : flat;
	pressure = flat * std::clamp(2 - spread / (kAlike * area), 0.0, 1.0);
}
}  // namespace ist
