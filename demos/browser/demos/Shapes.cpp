// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btCapsuleShape.h"
#include "BulletCollision/CollisionShapes/btConeShape.h"
#include "BulletCollision/CollisionShapes/btCylinderShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kSize = 0.2, kApart = 0.32;

/// Rotates a mesh so that the z axis of the generators becomes the y axis of Bullet's shapes.
Mesh upright(Mesh mesh)
{
	for (Vec3& p : mesh.vertices) p = {p.x, p.z, -p.y};
	return mesh;
}

/// The same body lies on each of Bullet's own shapes and on the ground. It can only move up and down, so that it stays on top of a cone.
class Shapes : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Result<Mesh> mesh = chosenMesh(options, kSize, knotMesh(kSize));
		if (!mesh) return mesh.error();
		if (auto error = makeSolid(m_solid, "body", mesh.value(), 1000, options)) return error;
		return std::nullopt;
	}
	bool hasStockSide() const override { return true; }
	double duration() const override { return 2.5; }
	Viewpoint viewpoint() const override { return {{0, 0.15, 0}, 1.75, 0.5, 0.42}; }
	std::vector<Figure> figures() const override
	{
		static const char* const names[] = {"plane", "box", "sphere", "capsule", "cylinder", "cone"};
		const double weight = 1000 * m_solid->tree->volume * kGravity;
		std::vector<Figure> figures;
		for (size_t i = 0; i < m_bodies.size(); ++i)
			figures.push_back({std::string("force of the ") + names[i], "N", world().contactForce(m_bodies[i]).y, weight, 0.01 * weight});
		return figures;
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		w.addPlane({0, 1, 0}, 0, 0.5);
		m_bodies.clear();
		const double tops[] = {0, 0.12, 0.16, 0.14, 0.12, 0.16};
		for (int i = 0; i < 6; ++i)
		{
			const Vec3 place{kApart * (i % 3 - 1), 0, kApart * (i / 3 - 0.5)};
			addPedestal(w, i, place);
			BodySetup body;
			body.name = "body " + std::to_string(i + 1);
			body.dissipation = 20;
			body.colour = bodyColour(i == 0 ? 5 : i);
			body.X_WM.translation = place + Vec3{0, tops[i] - bounds(m_solid->mesh).lower.y + 0.02, 0} - m_solid->X_MP.translation;
			btRigidBody* added = w.add(m_solid, std::move(body));
			if (!added) return std::nullopt;
			added->setLinearFactor(btVector3(0, 1, 0));
			added->setAngularFactor(btScalar(0));
			m_bodies.push_back(added);
		}
		return std::nullopt;
	}
	double arrowForce() const override { return 1000 * m_solid->tree->volume * kGravity; }
	double arrowLength() const override { return 0.12; }

private:
	void addPedestal(DemoWorld& w, int kind, const Vec3& place)
	{
		std::unique_ptr<btCollisionShape> shape;
		Mesh mesh;
		double height = 0.06;
		const auto s = [](double x) { return btScalar(x); };
		switch (kind)
		{
		case 1: shape = std::make_unique<btBoxShape>(btVector3(s(0.09), s(0.06), s(0.09))), mesh = makeBoxMesh({0.09, 0.06, 0.09}); break;
		case 2: shape = std::make_unique<btSphereShape>(s(0.08)), mesh = makeSphereMesh(0.08), height = 0.08; break;
		case 3:
			shape = std::make_unique<btCapsuleShape>(s(0.05), s(0.04)), mesh = upright(makeCapsuleMesh(0.05, 0.02)), height = 0.07;
			break;
		case 4:
			shape = std::make_unique<btCylinderShape>(btVector3(s(0.09), s(0.06), s(0.09))), mesh = upright(makeCylinderMesh(0.09, 0.06));
			break;
		case 5: shape = std::make_unique<btConeShape>(s(0.08), s(0.16)), mesh = upright(makeConeMesh(0.08, 0.16)), height = 0.08; break;
		default: return;
		}
		BodySetup pedestal;
		static const char* const names[] = {"", "box", "sphere", "capsule", "cylinder", "cone"};
		pedestal.name = names[kind];
		pedestal.fixed = true;
		pedestal.colour = {0.72f, 0.75f, 0.79f};
		pedestal.X_WM.translation = place + Vec3{0, height, 0};
		w.addShape(std::move(shape), std::move(mesh), std::move(pedestal));
	}

	SolidPtr m_solid;
	std::vector<btRigidBody*> m_bodies;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeShapes() { return std::make_unique<Shapes>(); }
}  // namespace browser
