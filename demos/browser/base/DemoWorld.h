// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"
#include "demos/browser/base/DemoSolid.h"
#include "demos/browser/base/StockShape.h"
#include "demos/scenes/Extremes/ExtremeWorld.h"

#include "BulletDynamics/ConstraintSolver/btTypedConstraint.h"

#include <memory>
#include <string>
#include <vector>

namespace browser
{
/// How a body is put into a world.
struct BodySetup
{
	std::string name;
	double mass = 0;          ///< [kg]; 0: from the density, unless fixed
	double density = 1000;    ///< [kg/m^3]
	double stiffness = 0;     ///< k_X [Pa/m]; 0: the default rule
	double dissipation = -1;  ///< [s/m]; negative: the default
	double friction = 0.5;    ///< Bullet multiplies those of both bodies
	bool fixed = false;
	ist::Pose X_WM;  ///< of the mesh as it was given to makeSolid
	Colour colour;
	std::unique_ptr<btCollisionShape> shape;  ///< for Bullet; where missing, the convex hull of the mesh, in a stock world makeStockShape
};

/// Sums over the volumetric contacts of the last step.
struct ContactSums
{
	double force = 0;       ///< of magnitudes [N]
	double forceError = 0;  ///< that the queries and what was kept or merged of them may have, as if each pair's were independent [N]
	double volume = 0;      ///< [m^3]
	long long pairs = 0, patches = 0;
	double queryMicroseconds = 0;
};

/// What Bullet's own contact said of two bodies in the last step, World.
struct StockContact
{
	const btCollisionObject *bodyA = nullptr, *bodyB = nullptr;
	std::vector<ist::Vec3> points;  ///< that touch
	ist::Vec3 center;               ///< their mean
	ist::Vec3 impulse;              ///< on A, friction included [N s]
};

/// A Bullet world, ours or the stock one, whose bodies can be drawn. Errors of `add` stay in `error()`, and nothing is added.
class DemoWorld
{
public:
	struct Body
	{
		std::string name;
		SolidPtr solid;  ///< null for Bullet's own shapes
		ist::Mesh mesh;  ///< of one without a solid
		std::shared_ptr<const SurfaceModel> surface;
		std::unique_ptr<btStridingMeshInterface> triangles;  ///< of the shape, where it reads some
		std::unique_ptr<btCollisionShape> shape;
		std::unique_ptr<btRigidBody> body;
		btISTAttachment attachment;
		Colour colour;

		ist::Pose X_WP() const;  ///< of the principal frame
		const ist::Mesh& visibleMesh() const { return solid ? solid->mesh : mesh; }
	};

	explicit DemoWorld(scenes::Response response, const ist::Vec3& gravity = {0, -9.81, 0});
	~DemoWorld();
	DemoWorld(const DemoWorld&) = delete;
	DemoWorld& operator=(const DemoWorld&) = delete;

	/// Static plane through the origin's shift along its unit normal.
	btRigidBody* addPlane(const ist::Vec3& normal, double offset, double friction, const btContactMaterial& material = {});
	btRigidBody* add(const SolidPtr& solid, BodySetup setup);
	/// One of Bullet's shapes, drawn as `mesh`.
	btRigidBody* addShape(std::unique_ptr<btCollisionShape> shape, ist::Mesh mesh, BodySetup setup);
	/// Owned from here on.
	void addConstraint(std::unique_ptr<btTypedConstraint> constraint);

	void step(double h);
	btDiscreteDynamicsWorld& bullet();
	/// Null in a stock world.
	btISTWorld* volumetric() { return m_volumetric.get(); }
	const std::vector<Body>& bodies() const { return m_bodies; }
	const std::optional<ist::Error>& error() const { return m_error; }

	/// Of the volumetric contacts; in a stock world the force alone.
	ContactSums contactSums() const;
	/// Empty unless this is a stock world.
	std::vector<StockContact> stockContacts() const;
	/// Force on `body` from all contacts of the world's kind with it in the last step, or with `other` alone [N].
	ist::Vec3 contactForce(const btCollisionObject* body, const btCollisionObject* other = nullptr) const;
	/// Kinetic energy and that in the field of gravity [J].
	double mechanicalEnergy() const;
	double lastStep() const { return m_lastStep; }
	double stepMicroseconds() const { return m_stepMicroseconds; }
	void keepAwake(bool on);
	/// Bullet's own lines of boxes and constraints.
	void debugLines(const DrawChoice& choice, DrawList& list);

private:
	struct Stock;
	btRigidBody* enter(Body&& body, const BodySetup& setup, double mass, const btVector3& inertia, const ist::Pose& X_WP);

	std::unique_ptr<Stock> m_stock;
	std::unique_ptr<btISTWorld> m_volumetric;
	std::vector<Body> m_bodies;
	std::vector<std::unique_ptr<btTypedConstraint>> m_constraints;
	std::vector<std::unique_ptr<btCollisionShape>> m_planeShapes;
	std::vector<std::unique_ptr<btRigidBody>> m_planes;
	std::optional<ist::Error> m_error;
	double m_lastStep = 0, m_stepMicroseconds = 0;
};
}  // namespace browser
