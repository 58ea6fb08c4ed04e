// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Law/btContactLaw.h"

/// A body as a row sees it. What the solver cannot move has zeros.
struct btVolumetricRowBody
{
	ist::Vec3 inverseMass;                       ///< per World axis, for Bullet's linear factor [1/kg]
	ist::Mat3 inverseInertia = ist::zeroMat3();  ///< about the centre of mass, World axes [1/(kg m^2)]
	ist::Vec3 center;                            ///< of mass, World [m]
};

/// One patch as an implicit block of six rows with Coulomb friction: a step of backward Euler in the force. All in double.
///
/// Elastic part: impulse L = (I + S W)^-1 (h w0 - S u), S = h^2 K + h D, w0 the wrench at the beginning of the step, u the twist of A
/// relative to B that all else would give, W = J M^-1 J^T. Stable for every K, D and h that hold over the step (docs/stability.md says
/// where trees are so stiff that they do not); no inverse of K, so any rank will do. It never pulls: when its normal component is negative,
/// the impulse is zero. Backward Euler in the force.
///
/// Friction: force along the surface and drilling moment over the friction radius, together within a ball of radius mu L_n (the
/// ellipsoid that approximates the limit surface of a patch). No creep: within the ball the point does not slip.
class btVolumetricRow
{
public:
	/// `h` [s] is positive; `friction` is Coulomb's coefficient, 0 or more.
	void prepare(const btContactPatch& patch, const btVolumetricRowBody& A, const btVolumetricRowBody& B, double h, double friction);
	/// The same for any two things that an impulse can move: `response` is W, the change of the relative twist at the patch's point by
	/// an impulse on A there and its opposite on B.
	void prepare(const btContactPatch& patch, const ist::SymmetricMatrix6& response, double h, double friction);

	/// One visit of the iteration. `relative`: twist of A minus that of B at `point()`, with all impulses so far.
	/// Returns the change of the impulse on A, about `point()`.
	ist::Wrench solve(const ist::Twist& relative);

	const ist::Vec3& point() const { return m_point; }
	/// On A, about `point()` [N s, N m s].
	ist::Wrench impulse() const;
	/// The same without friction.
	ist::Wrench elasticImpulse() const;
	/// Its normal part [N s].
	double normalImpulse() const;

private:
	void prepareFriction(const double* eased);

	using Vector6 = double[6];
	using Matrix6 = double[36];   // symmetric
	using Matrix63 = double[18];  // column major
	ist::Vec3 m_point, m_normal;
	Matrix6 m_W;     // J M^-1 J^T
	Matrix6 m_C;     // (I + S W)^-1 S: the elastic impulse that a twist takes away
	Vector6 m_push;  // (I + S W)^-1 h w0: the elastic impulse when all else leaves no twist
	Matrix63 m_E;    // unit friction impulses; the third is a moment over the friction radius
	Matrix63 m_WE;   // the twists that these make
	Matrix63 m_CWE;  // the elastic impulse that these twists take away
	double m_EWE[9];
	double m_stick[9];   // pseudo-inverse of E^T (W^-1 + S)^-1 E: friction while the elastic part answers
	double m_slide = 0;  // 1 / largest eigenvalue of the same
	double m_friction = 0;
	Vector6 m_elastic = {};
	double m_tangent[3] = {};
};
