// SPDX-License-Identifier: Zlib
#include "demos/browser/base/ToolDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "TestSupport/SceneFiles/SceneShapes.h"

using namespace ist;

namespace browser
{
namespace
{
/// A plate lies on the sixteen points of a crown, as in data/scenes/crown.json.
class Crown : public ToolDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Mesh crown = scenes::makeCrownMesh();
		for (Vec3& p : crown.vertices) p = {p.x, p.z, -p.y};
		if (auto error = makeSolid(m_crown, "crown", crown, 10000, options)) return error;
		if (auto error = makeSolid(m_plate, "plate", makeBoxMesh({0.075, 0.004, 0.075}), 800, options)) return error;
		return std::nullopt;
	}
	double stepSize() const override { return 1e-3; }
	bool hasStockSide() const override { return true; }
	double duration() const override { return 1.5; }
	Viewpoint viewpoint() const override { return {{0, 0.04, 0}, 0.34, 0.5, 0.3}; }
	DrawChoice firstChoice() const override { return {.lenses = true}; }
	std::vector<Parameter> parameters() override
	{
		return {{"press by", "mm", &m_press, 0, 20, false, false}, {"tilt", "deg", &m_tilt, -8, 8, false, false}};
	}
	std::vector<Figure> figures() const override
	{
		const Vec3 force = world().contactForce(tool());
		const double sideways = std::hypot(force.x, force.z);
		return {{"force on the plate", "N", force.y}, {"hand and contact out of balance", "%", 100 * imbalance(), 0, 1},
			{"sideways share, none by symmetry", "%", norm(force) > 0 ? 100 * sideways / norm(force) : 0,
				m_tilt == 0 ? 0 : std::numeric_limits<double>::quiet_NaN(), 3}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		BodySetup crown;
		crown.name = "crown";
		crown.fixed = true;
		crown.stiffness = 1e11;
		crown.friction = 0.2;
		crown.colour = bodyColour(1);
		w.add(m_crown, std::move(crown));
		BodySetup plate;
		plate.name = "plate";
		plate.density = 2500;
		plate.stiffness = 1e11;
		plate.friction = 0.2;
		plate.colour = bodyColour(0);
		plate.X_WM = path(0);
		holdTool(w.add(m_plate, std::move(plate)), 200);
		return std::nullopt;
	}
	Pose path(double time) const override
	{
		constexpr double kTips = 0.07;
		Pose X;
		X.rotation = rotationMatrix(quaternionFromRotationVector({m_tilt * kDegree, 0, 0}));
		X.translation = along({{0, {0, kTips + 0.03, 0}}, {1, {0, kTips + 0.004 - 1e-3 * m_press, 0}}}, time);
		return X;
	}
	double arrowForce() const override { return 40; }
	double arrowLength() const override { return 0.04; }

private:
	SolidPtr m_crown, m_plate;
	double m_press = 8, m_tilt = 0;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeCrown() { return std::make_unique<Crown>(); }
}  // namespace browser
