// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include <array>
#include <variant>

class btCollisionShape;

/// What Bullet's plane, box, sphere, capsule, cylinder and cone are in closed form, local scaling included. The surface is the one that
/// the shape's own numbers speak of and that Bullet draws: boxes and cylinders with sharp edges, their margin within their extents; a
/// cone of its radius and height, without the margin that Bullet's own contact adds to it. Not installed.
class btISTShapeField
{
public:
	btISTShapeField() = default;
	explicit btISTShapeField(const btCollisionShape* shape);

	/// Null for every other shape, and for one with a length that is not positive and finite. Valid as long as this object.
	const ist::AnalyticField* field() const;
	bool isHalfSpace() const { return std::holds_alternative<ist::HalfSpaceField>(m_field); }
	/// Pose of the field's frame in the shape's.
	const ist::Pose& X_SF() const { return m_X_SF; }
	/// All numbers that the field is made of; of one shape they change with its scaling.
	const std::array<double, 4>& measures() const { return m_measures; }

private:
	std::variant<std::monostate, ist::HalfSpaceField, ist::BoxField, ist::CapsuleField, ist::CylinderField, ist::ConeField> m_field;
	ist::Pose m_X_SF;
	std::array<double, 4> m_measures{};
};
