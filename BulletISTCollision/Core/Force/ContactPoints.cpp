// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/ContactPoints.h"

#include "BulletISTCollision/Core/Base/PlaneAxes.h"
#include "BulletISTCollision/Core/Faces/Foundation.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
/// Sets the rectangle of a point whose normal and area are known.
void setExtent(ContactPoint& point, const ContactFace& face)
{
	Vec3 u, v;
	completeFrame(normalized(face.areaNormal), u, v);
	const PlaneAxes axes(dot(u, face.second * u), dot(v, face.second * v), dot(u, face.second * v));
	const double c = std::cos(axes.angle), s = std::sin(axes.angle);
	// A rectangle has the variance side^2 / 3.
	const auto side = [&](double moment) { return std::sqrt(3 * std::max(moment, 0.0) / face.area); };
	point.sides[0] = side(axes.larger) * (c * u + s * v);
	point.sides[1] = side(axes.smaller) * (c * v - s * u);
}

/// `sign`: 1 for a face of B, which presses A along its normal, and -1 for one of A. `stiffness`: with the weight of the other body.
ContactPoint pointOf(const ContactFace& face, double sign, double stiffness)
{
	ContactPoint point;
	const double size = norm(face.pressure);
	point.position = face.pressureCenter;
	point.normal = size > 0 ? (sign / size) * face.pressure : Vec3();
	point.area = face.area;
	point.pressure = face.area > 0 ? stiffness * size / face.area : 0;
	point.error = stiffness * face.error;
	point.ofA = sign < 0;
	point.center = face.center;
	point.slope = stiffness * face.gradient;
	if (face.area > 0 && size > 0) setExtent(point, face);
	return point;
}
}  // namespace

size_t contactPointCount(const OverlapResult& answer) { return answer.faceCountA + answer.faceCountB; }

size_t contactPoints(const OverlapResult& answer, const PressurePair& pair, ContactPoint* points, size_t capacity)
{
	const size_t count = std::min(capacity, contactPointCount(answer));
	double weightA = pair.weightA, weightB = pair.weightB;
	leanWeights(answer.leanOnA, answer.leanOnB, weightA, weightB);
	for (size_t i = 0; i < count; ++i)
		points[i] = i < answer.faceCountA ? pointOf(answer.facesA[i], -1, pair.stiffness * weightB)
										  : pointOf(answer.facesB[i - answer.faceCountA], 1, pair.stiffness * weightA);
	return count;
}
}  // namespace ist
