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
/// Settings of a body that is added to a world.
struct BodySetup
{
	std::string name;
	double mass = 0;          ///< mass [kg]; 0: from the density, unless fixed
	double density = 1000;    ///< density [kg/m^3]
	double stiffness = 0;     ///< k_X [Pa/m]; 0: the default rule
	double dissipation = -1;  ///< dissipation [s/m]; negative: the default
	double friction = 0.5;    ///< friction coefficient; Bullet multiplies those of both bodies
	bool fixed = false;
	ist::Pose X_WM;  ///< pose of the mesh that was given to makeSolid
	Colour colour;
	std::unique_ptr<btCollisionShape> shape;  ///< shape for Bullet; null: the mesh's convex hull, or makeStockShape in a stock world
};

/// Sums over the volumetric contacts of the last step.
struct ContactSums
{
	double force = 0;  ///< sum of the magnitudes of the forces [N]
	/// error of `force` from queries, cached results and merged levels, if the errors of the pairs were independent [N]
	double forceError = 0;
	double volume = 0;  ///< sum of the overlap volumes [m^3]
	long long pairs = 0, patches = 0;
	double queryMicroseconds = 0;
};

/// Bullet's own contact between two bodies in the last step, World.
struct StockContact
{
	const btCollisionObject *bodyA = nullptr, *bodyB = nullptr;
	std::vector<ist::Vec3> points;  ///< points that touch
	ist::Vec3 center;               ///< mean of the points
	ist::Vec3 impulse;              ///< impulse on A, including friction [N s]
};

/// A Bullet world with our contact or Bullet's own, whose bodies can be drawn. After an error in `add`, `error()` returns it, and nothing
/// more is added.
class DemoWorld
{
public:
	struct Body
	{
		std::string name;
		SolidPtr solid;  ///< null for Bullet's own shapes
		ist::Mesh mesh;  ///< mesh of a body without a solid
		std::shared_ptr<const SurfaceModel> surface;
		std::unique_ptr<btStridingMeshInterface> triangles;  ///< triangles that the shape refers to; may be null
		std::unique_ptr<btCollisionShape> shape;
		std::unique_ptr<btRigidBody> body;
		btISTAttachment attachment;
		Colour colour;

		ist::Pose X_WP() const;  ///< pose of the principal frame
		const ist::Mesh& visibleMesh() const { return solid ? solid->mesh : mesh; }
	};

	explicit DemoWorld(scenes::Response response, const ist::Vec3& gravity = {0, -9.81, 0});
	~DemoWorld();
	DemoWorld(const DemoWorld&) = delete;
	DemoWorld& operator=(const DemoWorld&) = delete;

	/// Adds a static plane with the unit normal `normal`, at `offset` along it from the origin.
	btRigidBody* addPlane(const ist::Vec3& normal, double offset, double friction, const btContactMaterial& material = {});
	btRigidBody* add(const SolidPtr& solid, BodySetup setup);
	/// Adds one of Bullet's shapes, drawn as `mesh`.
	btRigidBody* addShape(std::unique_ptr<btCollisionShape> shape, ist::Mesh mesh, BodySetup setup);
	/// Removes a body that was added and has no constraint.
	void remove(const btRigidBody* body);
	/// Adds a constraint; the world owns it from then on.
	void addConstraint(std::unique_ptr<btTypedConstraint> constraint);

	void step(double h);
	btDiscreteDynamicsWorld& bullet();
	/// Our world; null in a stock world.
	btISTWorld* volumetric() { return m_volumetric.get(); }
	const std::vector<Body>& bodies() const { return m_bodies; }
	const std::vector<std::unique_ptr<btRigidBody>>& planes() const { return m_planes; }
	size_t constraintCount() const { return m_constraints.size(); }
	const std::optional<ist::Error>& error() const { return m_error; }

	/// Sums over the volumetric contacts. In a stock world only the force is set.
	ContactSums contactSums() const;
	/// Bullet's contacts; empty unless this is a stock world.
	std::vector<StockContact> stockContacts() const;
	/// Force on `body` from all contacts of the world's kind in the last step, or only from those with `other` [N].
	ist::Vec3 contactForce(const btCollisionObject* body, const btCollisionObject* other = nullptr) const;
	/// Kinetic energy plus the energy in gravity [J].
	double mechanicalEnergy() const;
	double lastStep() const { return m_lastStep; }
	double stepMicroseconds() const { return m_stepMicroseconds; }
	void keepAwake(bool on);
	/// Adds Bullet's own lines of boxes and constraints.
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
