// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "demos/scenes/Extremes/FloatingBodies.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kWidth = 0.2, kLength = 0.5, kBall = 0.1;

/// Bodies float in water, which is a plane with hydrostatic pressure.
class Floating : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Result<Mesh> mesh = chosenMesh(options, 0.35, knotMesh(0.35));
		if (!mesh) return mesh.error();
		if (auto error = makeSolid(m_log, "log", makeBoxMesh({kWidth / 2, kWidth / 2, kLength / 2}), 1000, options)) return error;
		if (auto error = makeSolid(m_ball, "ball", makeSphereMesh(kBall, 4), 800, options)) return error;
		if (auto error = makeSolid(m_knot, "body", mesh.value(), 1000, options, true)) return error;
		return std::nullopt;
	}
	double stepSize() const override { return 1.0 / 120; }
	double duration() const override { return 12; }
	Viewpoint viewpoint() const override { return {{0, 0, 0}, 1.8, 0.5, 0.32}; }
	std::vector<Parameter> parameters() override { return {{"density of the log", "kg/m^3", &m_density, 50, 950, true, false}}; }
	std::vector<Figure> figures() const override
	{
		const double share = m_density / scenes::kWater, exact = scenes::wallSidedTilt(std::min(share, 1 - share));
		const Mat3 R = world().bodies()[0].X_WP().rotation;
		// A square can lie on four faces.
		const double turned = std::atan2(R.m[1][0], R.m[0][0]), quarter = 1.5707963267948966,
					 tilt = std::fabs(turned - quarter * std::round(turned / quarter));
		const double ballHeight = world().bodies()[1].X_WP().translation.y, knotWeight = 600 * m_knot->tree->volume * kGravity;
		// The closed form holds while the upper edges stay dry and the lower ones wet.
		const bool known = exact > 0 ? std::tan(exact) < 2 * std::min(share, 1 - share) : true;
		return {{"tilt of the log", "rad", tilt, known ? exact : std::numeric_limits<double>::quiet_NaN(), std::max(0.06 * exact, 0.05)},
			{"height of the ball, half as dense as water", "mm", 1e3 * ballHeight, 0, 0.02 * 1e3 * kBall},
			{"force of the water on the third body", "N", world().contactForce(world().bodies()[2].body.get()).y, knotWeight,
				0.02 * knotWeight}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		btContactMaterial water = btContactMaterial::fluid(scenes::kWater);
		water.dissipation = 0.6;
		w.addPlane({0, 1, 0}, 0, 0, water);
		const SolidPtr solids[] = {m_log, m_ball, m_knot};
		const double densities[] = {m_density, 0.5 * scenes::kWater, 600};
		const Vec3 places[] = {{-0.35, kWidth * (0.5 - m_density / scenes::kWater), 0}, {0.1, 0.05, 0.22}, {0.35, 0.12, -0.1}};
		for (int i = 0; i < 3; ++i)
		{
			BodySetup body;
			body.name = i == 0 ? "log" : i == 1 ? "ball" : "body";
			body.density = densities[i];
			body.colour = i == 0 ? Colour{0.72f, 0.50f, 0.28f} : bodyColour(i == 1 ? 1 : 3);
			body.X_WM.translation = places[i] - solids[i]->X_MP.translation;
			if (i == 0) body.X_WM.rotation = rotationMatrix(quaternionFromRotationVector({0, 0, 0.05}));
			btRigidBody* added = w.add(solids[i], std::move(body));
			if (!added) return std::nullopt;
			// The log can only heave and roll, as the closed form assumes.
			if (i == 0) added->setLinearFactor(btVector3(0, 1, 0)), added->setAngularFactor(btVector3(0, 0, 1));
			added->setDamping(btScalar(i == 0 ? 0 : 0.3), btScalar(i == 0 ? 0.2 : 0.5));
		}
		return std::nullopt;
	}
	void decorate(const DrawChoice&, DrawList& list) override { list.water = true, list.gridCell = 0.1; }
	double arrowForce() const override { return m_density * kWidth * kWidth * kLength * kGravity; }
	double arrowLength() const override { return 0.2; }

private:
	SolidPtr m_log, m_ball, m_knot;
	double m_density = 241.3;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeFloating() { return std::make_unique<Floating>(); }
}  // namespace browser
