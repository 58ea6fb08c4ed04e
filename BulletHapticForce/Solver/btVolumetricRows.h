// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactFriction.h"
#include "BulletHapticForce/Law/btContactLaw.h"

/// Inverse mass and inertia of a body, for a row. They are zero for a body that the solver cannot move.
struct btVolumetricRowBody
{
	ist::Vec3 inverseMass;                       ///< inverse mass per World axis, with Bullet's linear factor [1/kg]
	ist::Mat3 inverseInertia = ist::zeroMat3();  ///< inverse inertia about the centre of mass, World axes [1/(kg m^2)]
	ist::Vec3 center;                            ///< centre of mass, World [m]
};

/// One patch as an implicit block of six rows with Coulomb friction: a step of backward Euler in the force. All numbers are double.
///
/// Elastic part: the impulse is L = (I + S W)^-1 (h w0 - S u), with S = h^2 K + h D and W = J M^-1 J^T. w0 is the wrench at the beginning
/// of the step, and u the twist of A relative to B that all other impulses would give. It is stable for every K, D and h that are valid
/// during the step. docs/stability.md says where trees are too stiff for that. No inverse of K is needed, so K may have any rank. The
/// patch never pulls: if the normal component is negative, the impulse is zero.
///
/// Friction: the force along the surface and the drilling moment over the friction radius lie together within a ball of radius mu L_n, and
/// rolling and spinning friction within another (btContactFriction). There is no creep: within a ball nothing slips.
class btVolumetricRow
{
public:
	/// Prepares the row. `h` [s] must be positive.
	void prepare(const btContactPatch& patch, const btVolumetricRowBody& A, const btVolumetricRowBody& B, double h,
		const btContactFriction& friction);
	/// Prepares the row for any two objects that an impulse can move. `response` is W: the change of the relative twist at the patch's
	/// point by an impulse on A there and its opposite on B.
	void prepare(const btContactPatch& patch, const ist::SymmetricMatrix6& response, double h, const btContactFriction& friction);

	/// Visits the row once. `relative` is the twist of A minus that of B at `point()`, with all impulses so far. Returns the change of
	/// the impulse on A, about `point()`.
	ist::Wrench solve(const ist::Twist& relative);

	/// Share of a unit impulse elsewhere that the patch bears: w^T C w, where `w` is the relative twist at `point()` by that impulse.
	/// Subtracted from the response of that impulse, it gives the response of the loaded bodies.
	double borne(const ist::Twist& w) const;

	const ist::Vec3& point() const { return m_point; }
	/// Impulse on A, about `point()` [N s, N m s].
	ist::Wrench impulse() const;
	/// Impulse on A without friction, about `point()` [N s, N m s].
	ist::Wrench elasticImpulse() const;
	/// Normal part of the impulse [N s].
	double normalImpulse() const;

private:
	using Vector6 = double[6];
	using Matrix6 = double[36];   // symmetric
	using Matrix63 = double[18];  // column major
	/// One ball of friction.
	struct Friction
	{
		double coefficient = 0;
		Matrix63 E, WE, CWE;  // unit impulses; twists by them; reduction of the elastic impulse by these twists
		double stick[9];      // pseudo-inverse of E^T (W^-1 + S)^-1 E: impulse per slip, while the elastic part responds
		double slide = 0;     // 1 / largest eigenvalue of the same matrix
		double tangent[3] = {};
	};
	void addFriction(const btFrictionBall& ball, const double* eased);
	ist::Vec3 m_point, m_normal;
	Matrix6 m_W;     // J M^-1 J^T
	Matrix6 m_C;     // (I + S W)^-1 S: reduction of the elastic impulse by a twist
	Vector6 m_push;  // (I + S W)^-1 h w0: elastic impulse when all other impulses leave no twist
	Friction m_frictions[btContactFriction::kMostBalls];
	int m_frictionCount = 0;
	Vector6 m_elastic = {};
};
