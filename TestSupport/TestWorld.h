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
/// A place in World [m], with the axes of World or turned by `angle` [rad] about `axis` (any length but zero).
btTransform at(double x, double y, double z);
btTransform at(double x, double y, double z, const btVector3& axis, double angle);

/// A world for a game's own tests, in one line: bodies that it owns, steps of equal length in virtual time (no clock is ever read, the
/// same program gives the same motion), and an account of what happened. What cannot be done (a mesh that is not closed, a file that
/// is missing) throws std::runtime_error with the reason, which GoogleTest reports as a failure. Nothing ever sleeps.
///
///     ist::test::TestWorld world;
///     world.addMeshFile("bunny.obj", 0, at(0, 0, 0), .1).setFriction(1);  // 20 cm tall
///     btRigidBody& crate = world.addMesh(ist::makeBoxMesh({.08, .02, .08}), 1, at(0, .14, 0));
///     crate.setFriction(1);
///     world.run(3);
///     EXPECT_THAT(crate, IsAtRest());
class TestWorld
{
public:
	/// Gravity: (0, -9.81, 0) m/s^2. Trees are packed with so many spheres; see `keepTreesIn`.
	explicit TestWorld(int spheres = 1000) : m_spheres(spheres) {}
	~TestWorld();
	TestWorld(const TestWorld&) = delete;
	TestWorld& operator=(const TestWorld&) = delete;

	/// Trees of meshes are kept in this folder, so that the next run of the tests does not pack them again (ist::cachedTree).
	void keepTreesIn(const std::string& folder) { m_folder = folder; }

	/// A volumetric body of this mass [kg], 0: static. The mesh is moved so that its centre of mass is the body's origin; its axes stay.
	/// Of the inertia of a homogeneous body the moments about these axes are taken.
	btRigidBody& addMesh(const Mesh& mesh, double mass, const btTransform& pose);
	/// The same from a mesh file, times `unit` [m].
	btRigidBody& addMeshFile(const std::string& path, double mass, const btTransform& pose, double unit = 1);
	/// The same from an .ist file. Its mesh's centre of mass must be its origin unless the body is static.
	btRigidBody& addAsset(const std::string& path, double mass, const btTransform& pose);
	/// One of Bullet's shapes, which the caller keeps alive.
	btRigidBody& addShape(btCollisionShape& shape, double mass, const btTransform& pose);
	/// The half-space below y = `height`.
	btRigidBody& addFloor(double height = 0);
	/// The bodies of a scene file (data/scenes/README.md), with its materials, pairs, region and numbers of spheres, in its gravity. A hand
	/// and hooks take no part: what a hand would hold is a body like the others. Mistakes are thrown with file, line and field.
	void addScene(const std::string& path);
	/// One of those, by its name in the file.
	btRigidBody& body(const std::string& name);

	/// As many steps of `h` [s] as make up `seconds`.
	void run(double seconds, double h = 1.0 / 240);
	/// The accounts below begin here. To be called after bodies were moved, pushed, or put into or out of `world` by hand, which is
	/// nobody's impulse.
	void mark();

	btISTWorld& world() { return m_world; }
	/// Virtual time since the beginning [s].
	double time() const { return m_time; }
	/// Since the last mark.
	const ContactLog& log() const { return m_log; }
	const btEnergyBalance& energy() const { return m_audit->total(); }
	/// What kinetic, potential and contact energy have gained beyond what forces, kinematic bodies and the caller put in [J]. Negative
	/// where energy was dissipated, as it should be. Joints and Bullet's own contact count: they may not make energy either.
	double energyGained() const;
	/// Momentum of all rigid bodies that move, whoever added them, less that of the last mark, less what gravity and contacts with static
	/// and kinematic bodies gave them [N s]: zero, but for rounding, in a world without joints to the world, damping, forces of the caller,
	/// and contacts that push along an axis which a body's linear factor locks.
	Vec3 momentumFromNowhere() const;
	/// Of the fastest body that moves: see `speed`.
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

/// Of the fastest point of a body's bounding sphere [m/s].
double speed(const btRigidBody& body);
inline double speed(const TestWorld& world) { return world.fastest(); }
}  // namespace ist::test
