// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"
#include "demos/browser/catalog/BesideStock.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kEdge = 1;

/// A heavy cube stands on a light one.
class HeavyOnLight : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		if (auto error = makeSolid(m_cube, "cube", makeBoxMesh({kEdge / 2, kEdge / 2, kEdge / 2}), 1000, options)) return error;
		return std::nullopt;
	}
	double stepSize() const override { return 1.0 / 60; }
	bool hasStockSide() const override { return true; }
	double duration() const override { return 4; }
	Viewpoint viewpoint() const override { return {{0, 0.8 * kEdge, 0}, 5, 0.45, 0.22}; }
	std::vector<Parameter> parameters() override { return {{"mass of the upper one", "kg", &m_ratio, 1, 1e4, true, true}}; }
	std::vector<Figure> figures() const override
	{
		// F = k V in flat contact. The pair with the floor has twice the stiffness of the pair of cubes.
		const double top = m_ratio * kGravity, all = top + kGravity, k = stiffness();
		const double height = 1.5 * kEdge - all / (2 * k * kEdge * kEdge) - top / (k * kEdge * kEdge);
		return {{"force on the floor", "N", world().contactForce(m_lower, m_floor).y, all, 0.01 * all},
			{"height of the upper cube", "m", double(world().bodies()[1].body->getWorldTransform().getOrigin().y()), height, 0.004}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		m_floor = w.addPlane({0, 1, 0}, 0, 0.5);
		for (const bool upper : {false, true})
		{
			BodySetup cube;
			cube.name = upper ? "heavy cube" : "light cube";
			cube.mass = upper ? m_ratio : 1;
			cube.stiffness = 2 * stiffness();
			cube.colour = bodyColour(upper ? 6 : 0);
			cube.shape = std::make_unique<btBoxShape>(btVector3(kEdge / 2, kEdge / 2, kEdge / 2));
			cube.X_WM.translation = {0, upper ? 1.5 * kEdge : 0.5 * kEdge, 0};
			btRigidBody* added = w.add(m_cube, std::move(cube));
			if (!upper) m_lower = added;
		}
		return std::nullopt;
	}
	double arrowForce() const override { return m_ratio * kGravity; }
	double arrowLength() const override { return 0.6 * kEdge; }

private:
	/// Stiffness of the pair of cubes [Pa/m], with which the upper one sinks by 1 % of the edge.
	double stiffness() const { return m_ratio * kGravity / (0.01 * kEdge * kEdge * kEdge); }

	SolidPtr m_cube;
	btRigidBody *m_lower = nullptr, *m_floor = nullptr;
	double m_ratio = 1000;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeHeavyOnLight() { return std::make_unique<HeavyOnLight>(); }
std::unique_ptr<BrowsableDemo> makeStockAgainstOurs() { return std::make_unique<BesideStock>(makeHeavyOnLight); }
}  // namespace browser
