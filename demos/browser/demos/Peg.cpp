// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"
#include "demos/browser/drawing/Turned.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kHole = 0.020, kOuter = 0.045, kHeight = 0.06, kPegHalf = 0.05, kDensity = 7800;

/// A peg falls, tilted, through a hole with a small clearance, and stands on the ground.
class Peg : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		if (auto error = makeSolid(m_pipe, "pipe",
				turned({{kHole, 0}, {kOuter, 0}, {kOuter, kHeight}, {1.4 * kHole, kHeight}, {kHole, kHeight - 0.4 * kHole}}, 96, 0.006),
				2000, options))
			return error;
		Mesh peg = makeCylinderMesh(kHole - clearance(), kPegHalf, 64);
		for (Vec3& p : peg.vertices) p = {p.x, p.z, -p.y};
		if (auto error = makeSolid(m_peg, "peg", peg, 1000, options)) return error;
		return std::nullopt;
	}
	double stepSize() const override { return 1.0 / 480; }
	bool hasStockSide() const override { return true; }
	double duration() const override { return 2.5; }
	Viewpoint viewpoint() const override { return {{0, 0.05, 0}, 0.42, 0.5, 0.4}; }
	DrawChoice firstChoice() const override { return {.lenses = true}; }
	std::vector<Parameter> parameters() override
	{
		return {{"tilt at first", "deg", &m_tilt, 0, 12, true, false}, {"off centre by", "mm", &m_off, 0, 8, true, false}};
	}
	std::vector<Figure> figures() const override
	{
		const Vec3 at = world().bodies()[1].X_WP().translation;
		// In a hole of this height a peg may lean; it then stands on its edge.
		const double lean = kHole * 2 * clearance() / kHeight, weight = kDensity * m_peg->tree->volume * kGravity;
		return {{"force on the peg, ground and wall together", "N", world().contactForce(m_body).y, weight, 0.02 * weight},
			{"height of the peg's middle", "mm", 1e3 * at.y, 1e3 * (kPegHalf + 0.5 * lean), 1e3 * 0.5 * lean + 0.1},
			{"off the middle of the hole", "mm", 1e3 * std::hypot(at.x, at.z), 0, 1e3 * clearance() + 0.2}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		w.addPlane({0, 1, 0}, 0, 0.3);
		BodySetup pipe;
		pipe.name = "hole";
		pipe.fixed = true;
		pipe.stiffness = 1e9;
		pipe.friction = 0.2;
		pipe.colour = {0.62f, 0.68f, 0.75f};
		w.add(m_pipe, std::move(pipe));
		BodySetup peg;
		peg.name = "peg";
		peg.density = kDensity;
		peg.stiffness = 1e9;
		peg.friction = 0.2;
		peg.colour = bodyColour(1);
		peg.X_WM.translation = {1e-3 * m_off, kHeight + kPegHalf + 0.012, 0};
		peg.X_WM.rotation = rotationMatrix(quaternionFromRotationVector({0, 0, kDegree * m_tilt}));
		m_body = w.add(m_peg, std::move(peg));
		return std::nullopt;
	}
	void decorate(const DrawChoice&, DrawList& list) override { list.gridCell = 0.02; }
	double arrowForce() const override { return 2 * kDensity * m_peg->tree->volume * kGravity; }
	double arrowLength() const override { return 0.05; }

private:
	static constexpr double clearance() { return 0.0012; }
	SolidPtr m_pipe, m_peg;
	btRigidBody* m_body = nullptr;
	double m_tilt = 3, m_off = 3;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makePeg() { return std::make_unique<Peg>(); }
}  // namespace browser
