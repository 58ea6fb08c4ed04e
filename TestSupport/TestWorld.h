// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btEnergyAudit.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"
#include "TestSupport/ContactLog.h"

#include "BulletCollision/CollisionShapes/btCollisionShape.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ist::test
{
/// A pose at x, y, z in World [m], with the axes of World or rotated by `angle` [rad] about `axis` (any length but zero).
btTransform at(double x, double y, double z);
btTransform at(double x, double y, double z, const btVector3& axis, double angle);

/// A world for a game's own tests. It owns its bodies, steps them in equal steps of virtual time, and keeps an account of what happened.
/// It never reads a clock, so the same program gives the same motion. What cannot be done (a mesh that is not closed, a missing file)
/// throws std::runtime_error with the reason, which GoogleTest reports as a failure. Bodies never sleep.
///
///     ist::test::TestWorld world;
///     world.addMeshFile("bunny.obj", 0, at(0, 0, 0), 0.1).setFriction(1);  // 20 cm tall
///     btRigidBody& crate = world.addMesh(ist::makeBoxMesh({0.08, 0.02, 0.08}), 1, at(0, 0.14, 0));
///     crate.setFriction(1);
///     world.run(3);
///     EXPECT_THAT(crate, IsAtRest());
class TestWorld
{
public:
	/// Makes a world with the gravity (0, -9.81, 0) m/s^2. Trees are packed with so many spheres; see `keepTreesIn`.
	explicit TestWorld(int spheres = 1000) : m_spheres(spheres) {}
	~TestWorld();
	TestWorld(const TestWorld&) = delete;
	TestWorld& operator=(const TestWorld&) = delete;

	/// Stores the trees of meshes in this folder, so that the next run of the tests does not pack them again (ist::cachedTree).
	void keepTreesIn(const std::string& folder) { m_folder = folder; }

	/// Adds a volumetric body of this mass [kg]; 0: static. The mesh is translated so that its centre of mass is the body's origin; its
	/// axes stay. The moments of inertia are those of a homogeneous body about these axes.
	btRigidBody& addMesh(const Mesh& mesh, double mass, const btTransform& pose);
	/// Adds a body from a mesh file, whose coordinates are multiplied by `unit` [m].
	btRigidBody& addMeshFile(const std::string& path, double mass, const btTransform& pose, double unit = 1);
	/// Adds a body from an .ist file. The centre of mass of its mesh must be the origin, unless the body is static.
	btRigidBody& addAsset(const std::string& path, double mass, const btTransform& pose);
	/// Adds a body with one of Bullet's shapes, which the caller keeps alive.
	btRigidBody& addShape(btCollisionShape& shape, double mass, const btTransform& pose);
	/// Adds the half-space below y = `height`.
	btRigidBody& addFloor(double height = 0);
	/// Adds the bodies of a scene file (data/scenes/README.md) with its materials, pairs, region, numbers of spheres and gravity. Hand
	/// and hooks are ignored; the tool is a body like the others. Errors are thrown with file, line and field.
	void addScene(const std::string& path);
	/// A body of the scene file, by its name.
	btRigidBody& body(const std::string& name);

	/// Makes as many steps of `h` [s] as `seconds` contains.
	void run(double seconds, double h = 1.0 / 240);
	/// Restarts the accounts below. Call it after bodies were moved, pushed, or put into or out of `world` by hand, because the accounts
	/// do not contain such impulses.
	void mark();

	btISTWorld& world() { return m_world; }
	/// Virtual time since the world was made [s].
	double time() const { return m_time; }
	/// Contacts since the last mark.
	const ContactLog& log() const { return m_log; }
	const btEnergyBalance& energy() const { return m_audit->total(); }
	/// Gain of kinetic, potential and contact energy beyond what forces, kinematic bodies and the caller have put in [J]. It is negative
	/// where energy was dissipated, as it should be. Joints and Bullet's own contact are included: they must not create energy either.
	double energyGained() const;
	/// Gain of momentum of all moving rigid bodies since the last mark, including bodies that were not added by this class. The impulses
	/// of gravity and of contacts with static and kinematic bodies are subtracted [N s]. The result is zero up to rounding in most
	/// worlds. Exceptions are joints to the world, damping, forces of the caller, and contacts that push along an axis that a body's
	/// linear factor locks.
	Vec3 momentumFromNowhere() const;
	/// Speed of the fastest moving body: see `speed`.
	double fastest() const;

private:
	btRigidBody& addTree(std::shared_ptr<const InnerSphereTree> tree, double mass, const btTransform& pose);
	Vec3 momentum() const;

	btISTWorld m_world;
	int m_spheres;
	std::string m_folder;
	std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
	std::vector<btISTAttachment> m_attachments;
	std::map<std::string, btRigidBody*> m_named;
	ContactLog m_log{m_world.bullet(), m_world.contacts()};
	std::unique_ptr<btEnergyAudit> m_audit = std::make_unique<btEnergyAudit>(m_world.bullet(), m_world.contacts());
	double m_time = 0;
	Vec3 m_markMomentum, m_gravityImpulse;
};

/// Speed of the fastest point of a body's bounding sphere [m/s].
double speed(const btRigidBody& body);
inline double speed(const TestWorld& world) { return world.fastest(); }
}  // namespace ist::test
