// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/DemoWorld.h"

namespace browser
{
/// A hand that holds a body of a world by a virtual coupling in six degrees of freedom. It is the spring and damper of
/// devicebridge::couplingOnTool, with a stiffness in proportion to the body's mass.
class HandPull
{
public:
	bool holds() const { return m_body != nullptr; }
	const btRigidBody* body() const { return m_body; }
	/// Grabs `body` where it is; the body must not be fixed.
	void grab(btRigidBody* body);
	void release();
	/// Moves the target of the grip [m, rotation vector in World].
	void move(const ist::Vec3& shift, const ist::Vec3& turn);
	void setTarget(const ist::Pose& X_WH) { m_target = X_WH; }
	const ist::Pose& target() const { return m_target; }
	/// Applies the coupling for the next step. Returns the wrench on the body about its centre of mass, World.
	ist::Wrench pull(double h);
	/// Sets omega, the root of stiffness [N/m] over mass; the damping is critical.
	void setFrequency(double omega) { m_omega = omega; }

private:
	btRigidBody* m_body = nullptr;
	ist::Pose m_target;
	double m_omega = 40;  // root of the hand's stiffness over the body's mass [rad/s]
};

/// Distance along the ray from `from` in the unit direction `direction` to the first triangle of `mesh` in the pose X [m]; negative:
/// none.
double rayMeetsMesh(const ist::Mesh& mesh, const ist::Pose& X, const ist::Vec3& from, const ist::Vec3& direction);
}  // namespace browser
