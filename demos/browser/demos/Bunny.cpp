// SPDX-License-Identifier: Zlib
#include "demos/browser/base/ToolDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <algorithm>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kSize = 0.2, kBall = 0.025, kSoft = 2e6, kHard = 1.6e7;

/// A ball presses on a body, slides over it, and stays.
class Bunny : public ToolDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Result<Mesh> mesh = chosenMesh(options, kSize, knotMesh(kSize));
		if (!mesh) return mesh.error();
		if (auto error = makeSolid(m_body, "body", mesh.value(), 3000, options)) return error;
		DemoOptions own = options;
		own.spheres = 0;
		if (auto error = makeSolid(m_ball, "ball", makeSphereMesh(kBall, 4), 800, own)) return error;
		// The accuracy of so few spheres on a user's own mesh depends on where it is touched, so it is not judged.
		m_foreign = !options.mesh.empty();
		m_truth = std::make_unique<scenes::OverlapQuadrature>(m_ball->mesh, m_body->mesh);
		findTop();
		return std::nullopt;
	}
	double stepSize() const override { return 1e-3; }
	bool hasStockSide() const override { return true; }
	double duration() const override { return 2.5; }
	Viewpoint viewpoint() const override
	{
		const double height = m_top.y + 2 * kBall;
		return {{0, 0.42 * height, 0}, std::max(0.46, 2.6 * height), 0.7, 0.4};
	}
	DrawChoice firstChoice() const override { return {.lenses = true}; }
	std::vector<Parameter> parameters() override
	{
		return {{"press by", "mm", &m_press, 0, 10, false, false}, {"friction", "", &m_friction, 0, 1, true, false}};
	}
	std::vector<Figure> figures() const override
	{
		return {{"force on the ball", "N", norm(world().contactForce(tool()))},
			{"off the integral over the triangles", "%", m_off, m_friction > 0 || m_foreign ? std::numeric_limits<double>::quiet_NaN() : 0,
				6},
			{"hand and contact out of balance", "%", 100 * imbalance(), 0, 1}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		m_nextTruth = duration() - 1e-9;
		m_off = 0;
		BodySetup body;
		body.name = "body";
		body.fixed = true;
		body.stiffness = kSoft;
		body.friction = 1;
		body.colour = bodyColour(0);
		body.X_WM.translation = m_centre - m_body->X_MP.translation;
		m_fixed = w.add(m_body, std::move(body));
		BodySetup ball;
		ball.name = "ball";
		ball.density = 7800;
		ball.stiffness = kHard;
		ball.friction = m_friction;
		ball.colour = bodyColour(1);
		ball.X_WM = path(0);
		holdTool(w.add(m_ball, std::move(ball)), 250);
		return std::nullopt;
	}
	Pose path(double time) const override
	{
		const double deep = 1e-3 * m_press, above = m_top.y + kBall;
		Pose X;
		X.translation = along(
			{{0, {m_top.x, above + 0.03, m_top.z}}, {0.8, {m_top.x, above - deep, m_top.z}}, {1.2, {m_top.x, above - deep, m_top.z}},
				{1.7, {m_top.x - 0.010, above - deep, m_top.z}}, {2.2, {m_top.x - 0.002, above - deep, m_top.z}}},
			time);
		return X;
	}
	void afterStep(double) override
	{
		// The integral is computed at the end of the path, and every 0.5 s after it, because it takes longer than many steps.
		if (time() < m_nextTruth) return;
		m_nextTruth = time() + 0.5;
		const Vec3 truth = trueForce();
		m_off = norm(truth) > 0 ? 100 * norm(world().contactForce(tool()) - truth) / norm(truth) : 0;
	}
	double arrowForce() const override { return 2; }
	double arrowLength() const override { return 0.05; }

private:
	/// Finds the highest vertex of the standing body, where it is touched.
	void findTop()
	{
		const Box box = bounds(m_body->mesh);
		m_centre = {0, -box.lower.y, 0};
		m_top = {0, -1e300, 0};
		for (const Vec3& p : m_body->mesh.vertices)
			if (m_centre.y + p.y > m_top.y) m_top = m_centre + p;
	}
	/// True force by quadrature on the triangles, which uses neither spheres nor friction.
	Vec3 trueForce() const
	{
		const Pose X_WT = toPose(tool()->getWorldTransform()), X_TB = inverse(X_WT) * toPose(m_fixed->getWorldTransform());
		const double k = kSoft * kHard / (kSoft + kHard);
		return k * (X_WT.rotation * m_truth->integrate(X_TB, {}, 48, 20000).wrench(kSoft / (kSoft + kHard), kHard / (kSoft + kHard)).force);
	}

	SolidPtr m_body, m_ball;
	std::unique_ptr<scenes::OverlapQuadrature> m_truth;
	btRigidBody* m_fixed = nullptr;
	Vec3 m_centre, m_top;
	bool m_foreign = false;
	double m_press = 3, m_friction = 0, m_nextTruth = 0, m_off = 0;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeBunny() { return std::make_unique<Bunny>(); }
}  // namespace browser
