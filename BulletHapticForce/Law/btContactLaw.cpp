// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btContactLaw.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
using Matrix3 = Eigen::Matrix3d;
constexpr double kFrictionRadiusPerRms = 0.93;
// A resting body presses with its own weight, so only the load beyond twice that weight is taken as coming from above. With a larger
// share k would follow each bounce.
constexpr double kThrough = 0.5;
constexpr double kPressedBlend = 0.1;  // weight of each step in the running mean of the normal force

/// Largest k that a step of `h` [s] can bear [Pa/m]. There is no such bound on Bullet's own shapes (docs/stability.md).
double stiffestOfStep(const btISTContact& contact, double mass, double h)
{
	if (!contact.treeB) return std::numeric_limits<double>::infinity();
	const double gravity = contact.constants.gravity;
	const double resting = gravity > 0 ? std::max(mass, kThrough * contact.pressed / gravity) : mass;
	// Half of the smaller surface is the largest area of a flat contact. With the area of the present step, k would change with every
	// leaf that comes into touch, and bodies would not come to rest.
	const double area = 0.5 * std::min(contact.treeA->area, contact.treeB->area);
	return kStiffestPerStep * resting / (h * h * area);
}

Eigen::Vector3d toEigen(const ist::Vec3& v) { return {v.x, v.y, v.z}; }

Matrix3 toEigen(const ist::Mat3& a)
{
	Matrix3 r;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) r(i, j) = a.m[i][j];
	return r;
}

Matrix3 crossMatrix(const Eigen::Vector3d& v)
{
	Matrix3 r;
	r << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
	return r;
}

/// Transforms K from A's mesh axes about A's origin to World axes about the point `c`, which is given from that origin.
ist::SymmetricMatrix6 movedToWorld(const ist::SymmetricMatrix6& K, const Matrix3& R, const Eigen::Vector3d& c)
{
	Matrix3 forces, mixed, torques;  // force per translation, force per rotation, torque per rotation
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			forces(i, j) = K(i, j);
			mixed(i, j) = K(i, j + 3);
			torques(i, j) = K(i + 3, j + 3);
		}
	// A rotation about c moves the point at the origin by c x rotation.
	const Matrix3 X = crossMatrix(c);
	const Matrix3 shifted = forces * X + mixed;
	torques += mixed.transpose() * X - X * shifted;
	forces = R * forces * R.transpose();
	mixed = R * shifted * R.transpose();
	torques = R * torques * R.transpose();
	ist::SymmetricMatrix6 moved;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			moved(i, j + 3) = mixed(i, j);
			if (j < i) continue;
			moved(i, j) = forces(i, j);
			moved(i + 3, j + 3) = torques(i, j);
		}
	return moved;
}

/// Covariance of the overlap, Int r r^T dV / V about its centroid, in A's mesh axes [m^2].
Matrix3 covariance(const ist::OverlapIntegrals& sums, const Eigen::Vector3d& c)
{
	const double* s = sums.secondMoment;
	Matrix3 second;
	second << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
	return second / sums.volume - c * c.transpose();
}
}  // namespace

bool evaluateContactPatch(const btISTContact& contact, int patchIndex, btContactPatch& patch)
{
	const ist::OverlapIntegrals& sums = contact.patches[patchIndex];
	const ist::PressurePair pair{contact.constants.k, contact.constants.weightA, contact.constants.weightB};
	const ist::Wrench aboutOrigin = ist::pressureWrench(sums, pair);
	const double force = norm(aboutOrigin.force);
	if (!(sums.volume > 0) || !(force > 0) || !isFinite(aboutOrigin)) return false;

	const ist::Mat3& R_WA = contact.X_WA.rotation;
	const ist::Vec3 centroid = sums.firstMoment / sums.volume;
	patch.point = contact.X_WA * (contact.treeA->origin + centroid);
	patch.normal = R_WA * (aboutOrigin.force / force);
	patch.wrench = {R_WA * aboutOrigin.force, R_WA * (aboutOrigin.torque - cross(centroid, aboutOrigin.force))};

	const Eigen::Vector3d c = toEigen(centroid), n = toEigen(patch.normal);
	const Matrix3 R = toEigen(R_WA);
	const Matrix3 spread = R * covariance(sums, c) * R.transpose();
	const double radiusSquared = std::max(spread.trace() - n.dot(spread * n), 0.0);
	patch.frictionRadius = kFrictionRadiusPerRms * std::sqrt(radiusSquared);

	const double length = std::max(std::sqrt(radiusSquared), 1e-3 * std::cbrt(sums.volume));
	patch.stiffness = ist::projectedPositive(movedToWorld(ist::pressureStiffness(sums, pair), R, c), length);

	patch.damping = ist::SymmetricMatrix6();
	if (!(contact.constants.dissipation > 0)) return true;
	ist::SymmetricMatrix6 damping = movedToWorld(ist::pressureDamping(sums, pair), R, c);
	for (double& d : damping.m) d *= contact.constants.dissipation;
	patch.damping = ist::projectedPositive(damping, length);
	return true;
}

double carryLoad(btISTContact& contact, double load, double mass, double h)
{
	btISTPairConstants& constants = contact.constants;
	if (!(constants.load > 0)) return 1;
	double factor = 1;
	if (load > constants.load)
	{
		factor = load / constants.load;
		constants.load = load;
		constants.rule = btISTStiffnessRule::PileLoad;
	}
	const double stiffest = stiffestOfStep(contact, mass, h);
	if (factor * constants.k > stiffest)
	{
		factor = stiffest / constants.k;
		constants.rule = btISTStiffnessRule::StepBound;
	}
	constants.k *= factor;
	contact.error.force *= factor;
	return factor;
}

void notePressed(btISTContact& contact, double h)
{
	const double change = kPressedBlend * (contact.normalImpulse / h - contact.pressed);
	if (std::isfinite(change)) contact.pressed += change;
}

void multiply(btContactPatch& patch, double factor)
{
	patch.wrench = factor * patch.wrench;
	for (double& s : patch.stiffness.m) s *= factor;
	for (double& d : patch.damping.m) d *= factor;
}
