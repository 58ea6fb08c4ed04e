// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/btBulletHapticForceCommon.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

/// Common parts of the scenarios of the force library: bodies with trees in a btISTWorld, and oracles that do not use trees.
namespace scenario
{
constexpr bool kDouble = sizeof(btScalar) == 8;
using TreePtr = std::shared_ptr<const ist::InnerSphereTree>;

inline btVector3 vec(const ist::Vec3& v) { return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)); }
inline ist::Vec3 vec(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }

inline btTransform at(const ist::Vec3& p, const ist::Vec3& rotation = {})
{
	const ist::Quaternion q = ist::quaternionFromRotationVector(rotation);
	return btTransform(btQuaternion(btScalar(q.x), btScalar(q.y), btScalar(q.z), btScalar(q.w)), vec(p));
}

/// Mesh and tree about the mesh's centre of mass, as Bullet requires for its bodies.
struct Solid
{
	ist::Mesh mesh;
	TreePtr tree;

	Solid(const ist::Mesh& source, int64_t spheres) : mesh(source)
	{
		mesh = ist::translated(mesh, -ist::massProperties(mesh).centerOfMass);
		ist::BuildOptions options;
		options.maxSpheres = spheres;
		ist::Result<ist::InnerSphereTree> built = ist::buildTree(mesh, options);
		if (built) tree = std::make_shared<const ist::InnerSphereTree>(std::move(built).value());
		else ADD_FAILURE() << built.error().message;
	}
};

/// A cube with an edge of 1 m.
inline const Solid& cube()
{
	static const Solid solid(ist::makeBoxMesh({0.5, 0.5, 0.5}), 500);
	return solid;
}

/// A bar of 2 m by 0.2 m by 0.4 m.
inline const Solid& bar()
{
	static const Solid solid(ist::makeBoxMesh({1, 0.1, 0.2}), 4000);
	return solid;
}

/// Exact volume [m^3] of a closed mesh on the inner side of the plane normal . x = offset. The apex of all tetrahedra is in the plane, so
/// the face that closes the cut adds nothing.
inline double volumeBelow(const ist::Mesh& mesh, const ist::Vec3& normal, double offset)
{
	const ist::Vec3 apex = offset * normal;
	double six = 0;
	for (const auto& triangle : mesh.triangles)
	{
		ist::Vec3 kept[4];
		int count = 0;
		for (int i = 0; i < 3; ++i)
		{
			const ist::Vec3 p = mesh.vertices[triangle[size_t(i)]] - apex, q = mesh.vertices[triangle[size_t((i + 1) % 3)]] - apex;
			const double hp = dot(normal, p), hq = dot(normal, q);
			if (hp <= 0) kept[count++] = p;
			if ((hp < 0 && hq > 0) || (hp > 0 && hq < 0)) kept[count++] = p + (hp / (hp - hq)) * (q - p);
		}
		for (int i = 2; i < count; ++i) six += dot(kept[0], cross(kept[i - 1], kept[i]));
	}
	return six / 6;
}

/// Height y of the lowest vertex of a mesh in a pose.
inline double lowestPoint(const ist::Mesh& mesh, const ist::Pose& X)
{
	double y = 1e300;
	for (const ist::Vec3& p : mesh.vertices) y = std::min(y, (X * p).y);
	return y;
}

inline double height(const btRigidBody* body) { return double(body->getWorldTransform().getOrigin().y()); }

/// Angle between a body's y axis and the world's [rad].
inline double tilt(const btRigidBody* body) { return std::acos(std::clamp(double(body->getWorldTransform().getBasis()[1][1]), -1.0, 1.0)); }

/// Sum of the volumetric impulses on `object` in the last step, World [N s].
inline ist::Vec3 impulseOn(const btISTContactStore& store, const btCollisionObject* object)
{
	ist::Vec3 sum;
	for (const btISTContact* contact : store.contacts())
		for (int i = 0; i < contact->patchCount; ++i)
			sum += (contact->bodyA == object ? 1.0 : contact->bodyB == object ? -1.0 : 0.0) * contact->impulses[i].force;
	return sum;
}

/// Moment about an axis along z of the volumetric impulses on `object` in the last step [N m s].
inline double momentOn(const btISTContactStore& store, const btCollisionObject* object, const ist::Vec3& axis)
{
	double sum = 0;
	for (const btISTContact* contact : store.contacts())
		for (int i = 0; i < contact->patchCount; ++i)
		{
			const ist::OverlapIntegrals& patch = contact->patches[i];
			const ist::Vec3 point = contact->X_WA * (contact->treeA->origin + patch.firstMoment / patch.volume);
			const double moment = cross(point - axis, contact->impulses[i].force).z + contact->impulses[i].torque.z;
			sum += contact->bodyA == object ? moment : contact->bodyB == object ? -moment : 0;
		}
	return sum;
}

/// Bodies in their own world. They never sleep.
class Scene
{
public:
	btISTWorld world;

	~Scene()
	{
		for (auto& body : m_bodies) world.bullet().removeRigidBody(body.get());
	}

	template <class Shape, class... Arguments> Shape* shape(Arguments&&... arguments)
	{
		m_shapes.push_back(std::make_unique<Shape>(std::forward<Arguments>(arguments)...));
		return static_cast<Shape*>(m_shapes.back().get());
	}

	/// Makes a box shape, which only gives the size of the mesh: the contact comes from the tree.
	btCollisionShape* volumetricShape(const Solid& solid)
	{
		ist::Vec3 half;
		for (const ist::Vec3& p : solid.mesh.vertices) half = ist::componentMax(half, {std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
		btCollisionShape* result = shape<btBoxShape>(vec(half));
		auto attached = world.attach(result, solid.tree);
		EXPECT_TRUE(attached);
		if (attached) m_attachments.push_back(std::move(attached).value());
		return result;
	}

	/// Adds a body with equal moments of inertia about all axes, `inertia` [kg m^2], like a ball or cube. A mass of zero makes it static.
	btRigidBody* add(btCollisionShape* shape, double mass, double inertia, const btTransform& pose)
	{
		const btScalar i = btScalar(mass > 0 ? inertia : 0);
		m_bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, btVector3(i, i, i)));
		btRigidBody* body = m_bodies.back().get();
		body->setWorldTransform(pose);
		body->setInterpolationWorldTransform(pose);
		body->setActivationState(DISABLE_DEACTIVATION);
		world.bullet().addRigidBody(body);
		return body;
	}

	btRigidBody* addFloor() { return add(shape<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), 0, 0, btTransform::getIdentity()); }

	/// Sets k_X [Pa/m]; with 0 the default rule decides.
	void setStiffness(const btRigidBody* body, double k) { EXPECT_FALSE(world.materials().set(body, {k, -1})); }

	void step(double h) { world.bullet().stepSimulation(btScalar(h), 0); }
	void run(double seconds, double rate)
	{
		for (int i = 0; i < int(seconds * rate + 0.5); ++i) step(1 / rate);
	}

	/// Sum over all contacts of the impulses on A in the store, World [N s].
	ist::Vec3 storedImpulse()
	{
		ist::Vec3 sum;
		for (const btISTContact* contact : world.contacts().contacts())
			for (int i = 0; i < contact->patchCount; ++i) sum += contact->impulses[i].force;
		return sum;
	}

private:
	std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
	std::vector<btISTAttachment> m_attachments;
};

inline ist::Vec3 randomVector(std::mt19937_64& random, double size)
{
	std::uniform_real_distribution<double> u(-size, size);
	const double x = u(random), y = u(random);
	return {x, y, u(random)};
}
}  // namespace scenario
