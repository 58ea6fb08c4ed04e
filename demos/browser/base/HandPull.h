// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/DemoWorld.h"

namespace browser
{
/// A hand that holds a body of a world by a virtual coupling in six degrees of freedom: the spring and damper of
/// devicebridge::couplingOnTool, as strong as the body is heavy.
class HandPull
{
public:
	bool holds() const { return m_body != nullptr; }
	const btRigidBody* body() const { return m_body; }
	/// Holds `body` where it is. Not a fixed one.
	void grab(btRigidBody* body);
	void release();
	/// The grip wants to be there [m, rotation vector in World].
	void move(const ist::Vec3& shift, const ist::Vec3& turn);
	void setTarget(const ist::Pose& X_WH) { m_target = X_WH; }
	const ist::Pose& target() const { return m_target; }
	/// Pulls for the step that follows; the wrench on the body about its centre of mass, World.
	ist::Wrench pull(double h);
	/// Stiffness [N/m] over mass; damping is critical.
	void setFrequency(double omega) { m_omega = omega; }

private:
	btRigidBody* m_body = nullptr;
	ist::Pose m_target;
	double m_omega = 40;  // [rad/s]
};

/// Where the ray from `from` along the unit vector `direction` meets a triangle of `mesh` in the pose X first [m]; negative: nowhere.
double rayMeetsMesh(const ist::Mesh& mesh, const ist::Pose& X, const ist::Vec3& from, const ist::Vec3& direction);
}  // namespace browser
