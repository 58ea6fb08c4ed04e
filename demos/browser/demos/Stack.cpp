// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kRing = 0.12, kTube = 0.04, kMass = 2;
constexpr int kRings = 5;

/// Rings are stacked with a knot on top: no body of the stack is convex.
class Stack : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Mesh ring = makeTorusMesh(kRing, kTube);
		for (Vec3& p : ring.vertices) p = {p.x, p.z, -p.y};
		if (auto error = makeSolid(m_ring, "ring", ring, 1000, options)) return error;
		if (auto error = makeSolid(m_knot, "knot", knotMesh(0.3), 1000, options)) return error;
		return std::nullopt;
	}
	bool hasStockSide() const override { return true; }
	double duration() const override { return 3; }
	Viewpoint viewpoint() const override { return {{0, 0.24, 0}, 1.35, 0.6, 0.25}; }
	std::vector<Parameter> parameters() override { return {{"offset of each", "mm", &m_offset, 0, 40, true, false}}; }
	std::vector<Figure> figures() const override
	{
		double fastest = 0, mass = 0;
		Vec3 floor;
		for (const DemoWorld::Body& b : world().bodies())
		{
			fastest = std::max(fastest, double(b.body->getLinearVelocity().length()));
			mass += 1 / double(b.body->getInvMass());
			floor += world().contactForce(b.body.get(), m_floor);
		}
		return {{"force on the floor", "N", floor.y, mass * kGravity, 0.01 * mass * kGravity}, {"fastest body", "m/s", fastest, 0, 0.02},
			{"height of the knot", "m", double(world().bodies()[kRings].body->getWorldTransform().getOrigin().y())}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		m_floor = w.addPlane({0, 1, 0}, 0, 0.8);
		for (int i = 0; i < kRings; ++i)
		{
			BodySetup ring;
			ring.name = "ring " + std::to_string(i + 1);
			ring.mass = kMass;
			ring.stiffness = 5e6;
			ring.friction = 0.8;
			ring.colour = bodyColour(i);
			ring.X_WM.translation = {1e-3 * m_offset * ((i % 2) - 0.5), kTube * (2 * i + 1) + 1e-3 * i, 0};
			w.add(m_ring, std::move(ring));
		}
		BodySetup knot;
		knot.name = "knot";
		knot.mass = kMass;
		knot.stiffness = 5e6;
		knot.friction = 0.8;
		knot.colour = bodyColour(5);
		knot.X_WM.translation = {0, 2 * kTube * kRings - bounds(m_knot->mesh).lower.y + 0.03, 0};
		w.add(m_knot, std::move(knot));
		return std::nullopt;
	}
	double arrowForce() const override { return 2 * kRings * kMass * kGravity; }
	double arrowLength() const override { return 0.25; }

private:
	SolidPtr m_ring, m_knot;
	btRigidBody* m_floor = nullptr;
	double m_offset = 10;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeStack() { return std::make_unique<Stack>(); }
}  // namespace browser
