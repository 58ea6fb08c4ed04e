// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Force/ContactPoints.h"

#include <vector>

namespace ist
{
/// A tactile element on the surface of a body. Mesh frame of the body.
struct Taxel
{
	Vec3 position;      ///< [m]
	Vec3 normal;        ///< outward; unit length
	double radius = 0;  ///< it feels what presses nearer than this [m]
};

/// Tactile elements on a body, and the force that each feels. A point of contact at the distance d from a taxel has there the weight
/// (1 - d^2 / radius^2)^2, or 0 beyond the radius and where it presses from behind. Where weights sum to less than 1, the rest of its force
/// goes to `rest`; where they sum to more, they are divided by their sum. So the force of a taxel is continuous while contacts slide, and
/// all forces with `rest` add up to the force of the contacts. A point whose area is larger than half the radius of the smallest taxel is
/// divided, at most into kMostParts x kMostParts equal rectangles, each with its share of the pressure.
class TaxelArray
{
public:
	/// Refused if a taxel is not finite, its normal has no unit length, or its radius is not positive.
	static Result<TaxelArray> make(std::vector<Taxel> taxels);

	const std::vector<Taxel>& taxels() const { return m_taxels; }

	/// Sets all forces to zero. Call it before the contacts of a new moment.
	void clear();
	/// Adds points of contact. X_TP: pose of the points' frame in the mesh frame of this body. `sign`: 1 if the body of the taxels is A of
	/// the points, -1 if it is B. No allocation; O(points * taxels), 1 ns each, where a divided point counts as its parts.
	void add(const ContactPoint* points, size_t count, const Pose& X_TP, double sign);

	/// Force on each taxel, in the mesh frame of the body [N].
	const std::vector<Vec3>& forces() const { return m_forces; }
	/// Force that no taxel felt [N].
	const Vec3& rest() const { return m_rest; }

	static constexpr int kMostParts = 32;

private:
	void addForce(const Vec3& x, const Vec3& force);
	void addDivided(const ContactPoint& point, const int (&parts)[2], const Pose& X_TP, double sign);

	double m_leastRadius = 0;
	std::vector<Taxel> m_taxels;
	std::vector<Vec3> m_forces;
	std::vector<double> m_weights;
	Vec3 m_rest;
};
}  // namespace ist
