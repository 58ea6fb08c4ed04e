// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Force/ContactPoints.h"

#include <algorithm>

namespace ist
{
namespace
{
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
	return point;
}
}  // namespace

size_t contactPointCount(const OverlapResult& answer) { return answer.faceCountA + answer.faceCountB; }

size_t contactPoints(const OverlapResult& answer, const PressurePair& pair, ContactPoint* points, size_t capacity)
{
	const size_t count = std::min(capacity, contactPointCount(answer));
	for (size_t i = 0; i < count; ++i)
		points[i] = i < answer.faceCountA ? pointOf(answer.facesA[i], -1, pair.stiffness * pair.weightB)
										  : pointOf(answer.facesB[i - answer.faceCountA], 1, pair.stiffness * pair.weightA);
	return count;
}
}  // namespace ist
