// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kMass = 10, kGravity = 9.81;

/// The scene of demos/hello.
class Hello : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Mesh ring = makeTorusMesh(0.35, 0.15);
		for (Vec3& p : ring.vertices) p = {p.x, p.z, -p.y};
		if (auto error = makeSolid(m_ring, "ring", ring, 1000, options)) return error;
		return std::nullopt;
	}
	bool hasStockSide() const override { return true; }
	double duration() const override { return 2; }
	Viewpoint viewpoint() const override { return {{0, 0.25, 0}, 2.2, 0.6, 0.35}; }
	std::vector<Parameter> parameters() override
	{
		return {{"stiffness", "Pa/m", &m_stiffness, 1e4, 1e7, true, true}, {"dissipation", "s/m", &m_dissipation, 0, 100, true, false}};
	}
	std::vector<Figure> figures() const override
	{
		// At rest the contact force equals the weight (Newton).
		const double weight = 2 * kMass * kGravity;
		return {{"force on the floor", "N", world().contactForce(m_lying).y - world().contactForce(m_lying, m_falling).y, weight,
					0.01 * weight},
			{"speed of the upper ring", "m/s", double(m_falling->getLinearVelocity().length()), 0, 0.01}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		w.addPlane({0, 1, 0}, 0, 0.5);
		for (const bool falls : {false, true})
		{
			BodySetup setup;
			setup.name = falls ? "falling ring" : "lying ring";
			setup.mass = kMass;
			setup.stiffness = m_stiffness;
			setup.dissipation = m_dissipation;
			setup.colour = bodyColour(falls ? 1 : 0);
			setup.X_WM.translation = {falls ? 0.02 : 0, falls ? 0.55 : 0.15, 0};
			(falls ? m_falling : m_lying) = w.add(m_ring, std::move(setup));
		}
		return std::nullopt;
	}
	double arrowForce() const override { return kMass * kGravity; }
	double arrowLength() const override { return 0.2; }

private:
	SolidPtr m_ring;
	btRigidBody *m_lying = nullptr, *m_falling = nullptr;
	double m_stiffness = 1e5, m_dissipation = 20;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeHello() { return std::make_unique<Hello>(); }
}  // namespace browser
