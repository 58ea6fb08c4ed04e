// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTShapeField.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btCapsuleShape.h"
#include "BulletCollision/CollisionShapes/btConeShape.h"
#include "BulletCollision/CollisionShapes/btCylinderShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

namespace
{
/// A cyclic permutation of axes that maps z to `axis`.
ist::Pose alongAxis(int axis)
{
	ist::Pose X;
	X.rotation = ist::zeroMat3();
	for (int i = 0; i < 3; ++i) X.rotation.m[(axis + 1 + i) % 3][i] = 1;
	return X;
}
}  // namespace

btISTShapeField::btISTShapeField(const btCollisionShape* shape)
{
	switch (shape->getShapeType())
	{
	case STATIC_PLANE_PROXYTYPE:
	{
		const auto* plane = static_cast<const btStaticPlaneShape*>(shape);
		const ist::Vec3 normal = toVec3(plane->getPlaneNormal());
		m_measures = {double(plane->getPlaneConstant()), normal.x, normal.y, normal.z};
		m_field = ist::HalfSpaceField(ist::normalized(normal), m_measures[0]);
		break;
	}
	case BOX_SHAPE_PROXYTYPE:
	{
		const ist::Vec3 half = toVec3(static_cast<const btBoxShape*>(shape)->getHalfExtentsWithMargin());
		m_measures = {half.x, half.y, half.z};
		m_field = ist::BoxField(half);
		break;
	}
	case SPHERE_SHAPE_PROXYTYPE:
		m_measures = {double(static_cast<const btSphereShape*>(shape)->getRadius())};
		m_field = ist::CapsuleField(m_measures[0], 0);
		break;
	case CAPSULE_SHAPE_PROXYTYPE:
	{
		const auto* capsule = static_cast<const btCapsuleShape*>(shape);
		m_measures = {double(capsule->getRadius()), double(capsule->getHalfHeight())};
		m_field = ist::CapsuleField(m_measures[0], m_measures[1]);
		m_X_SF = alongAxis(capsule->getUpAxis());
		break;
	}
	case CYLINDER_SHAPE_PROXYTYPE:
	{
		const auto* cylinder = static_cast<const btCylinderShape*>(shape);
		const int axis = cylinder->getUpAxis();
		m_measures = {double(cylinder->getRadius()), double(cylinder->getHalfExtentsWithMargin()[axis])};
		m_field = ist::CylinderField(m_measures[0], m_measures[1]);
		m_X_SF = alongAxis(axis);
		break;
	}
	case CONE_SHAPE_PROXYTYPE:
	{
		const auto* cone = static_cast<const btConeShape*>(shape);
		m_measures = {double(cone->getRadius()), double(cone->getHeight())};
		m_field = ist::ConeField(m_measures[0], m_measures[1]);
		m_X_SF = alongAxis(cone->getConeUpIndex());
		break;
	}
	default: break;
	}
}
