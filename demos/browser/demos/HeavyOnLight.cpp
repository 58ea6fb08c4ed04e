// SPDX-License-Identifier: Zlib
#include "demos/browser/WorldDemo.h"

#include "BulletISTCollision/Core/MeshShapes.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kEdge = 1;

/// A heavy cube stands on a light one: in our world, or in Bullet's own beside it from the same start.
class HeavyOnLight : public WorldDemo
{
public:
	explicit HeavyOnLight(bool besideStock) : m_besideStock(besideStock) {}

	std::optional<Error> prepare(const DemoOptions& options) override
	{
		if (auto error = makeSolid(m_cube, "cube", makeBoxMesh({kEdge / 2, kEdge / 2, kEdge / 2}), 1000, options)) return error;
		return std::nullopt;
	}
	double stepSize() const override { return 1.0 / 60; }
	double duration() const override { return 4; }
	Viewpoint viewpoint() const override { return {{0, 0.8 * kEdge, 0}, m_besideStock ? 6.5 : 5.0, 0.45, 0.22}; }
	std::vector<Parameter> parameters() override { return {{"mass of the upper one", "kg", &m_ratio, 1, 1e4, true, true}}; }
	std::vector<Figure> figures() const override
	{
		// F = k V in flat contact: the floor's pair has twice the stiffness of the cubes'.
		const double top = m_ratio * kGravity, all = top + kGravity, k = stiffness();
		const double height = 1.5 * kEdge - all / (2 * k * kEdge * kEdge) - top / (k * kEdge * kEdge);
		std::vector<Figure> figures = {{"force on the floor", "N", world().contactForce(m_lower, m_floor).y, all, 0.01 * all},
									   {"height of the upper cube", "m", heightOf(0), height, 0.004}};
		if (m_besideStock) figures.push_back({"height of the upper cube in stock Bullet", "m", heightOf(1)});
		return figures;
	}

protected:
	std::optional<Error> build() override
	{
		const Vec3 aside{m_besideStock ? 0.95 * kEdge : 0, 0, 0};
		fill(addWorld(scenes::Response::Volumetric, {0, -kGravity, 0}, aside, m_besideStock ? "BulletHaptics" : ""));
		m_lower = world().bodies()[0].body.get();
		if (m_besideStock) fill(addWorld(scenes::Response::Stock, {0, -kGravity, 0}, -aside, "stock Bullet"));
		return std::nullopt;
	}
	double arrowForce() const override { return m_ratio * kGravity; }
	double arrowLength() const override { return 0.6 * kEdge; }

private:
	/// Of the pair of cubes: the upper one sinks by 1 % of the edge [Pa/m].
	double stiffness() const { return m_ratio * kGravity / (0.01 * kEdge * kEdge * kEdge); }
	double heightOf(size_t part) const { return double(world(part).bodies()[1].body->getWorldTransform().getOrigin().y()); }
	void fill(DemoWorld& w)
	{
		btRigidBody* floor = w.addPlane({0, 1, 0}, 0, 0.5);
		if (w.volumetric()) m_floor = floor;
		for (const bool upper : {false, true})
		{
			BodySetup cube;
			cube.name = upper ? "heavy cube" : "light cube";
			cube.mass = upper ? m_ratio : 1;
			cube.stiffness = 2 * stiffness();
			cube.colour = bodyColour(upper ? 6 : 0);
			cube.shape = std::make_unique<btBoxShape>(btVector3(kEdge / 2, kEdge / 2, kEdge / 2));
			cube.X_WM.translation = {0, upper ? 1.5 * kEdge : 0.5 * kEdge, 0};
			w.add(m_cube, std::move(cube));
		}
	}

	bool m_besideStock;
	SolidPtr m_cube;
	btRigidBody *m_lower = nullptr, *m_floor = nullptr;
	double m_ratio = 1000;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeHeavyOnLight() { return std::make_unique<HeavyOnLight>(false); }
std::unique_ptr<BrowsableDemo> makeStockAgainstOurs() { return std::make_unique<HeavyOnLight>(true); }
}  // namespace browser
