// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include <array>
#include <variant>

class btCollisionShape;

/// Bullet's plane, box, sphere, capsule, cylinder or cone in closed form, local scaling included. The surface is the one that the shape's
/// dimensions describe and that Bullet draws. Boxes and cylinders have sharp edges and include their margin; a cone has its radius and
/// height, without the margin that Bullet's own contact adds. Not installed.
class btISTShapeField
{
public:
	btISTShapeField() = default;
	explicit btISTShapeField(const btCollisionShape* shape);

	/// The closed form; null for every other shape, and for one with a length that is not positive and finite. Valid during this object's
	/// life.
	const ist::AnalyticField* field() const { return ist::fieldIn(m_field); }
	/// The closed form as a value that can be copied; it holds nothing for every other shape.
	const ist::AnyField& any() const { return m_field; }
	bool isHalfSpace() const { return std::holds_alternative<ist::HalfSpaceField>(m_field); }
	/// Pose of the field's frame in the shape's.
	const ist::Pose& X_SF() const { return m_X_SF; }
	/// All numbers that define the field. For a given shape they change only with its scaling.
	const std::array<double, 4>& measures() const { return m_measures; }

private:
	ist::AnyField m_field;
	ist::Pose m_X_SF;
	std::array<double, 4> m_measures{};
};
