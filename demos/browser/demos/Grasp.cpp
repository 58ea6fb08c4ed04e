// SPDX-License-Identifier: Zlib
#include "demos/browser/ToolDemo.h"

#include "BulletISTCollision/Core/MeshShapes.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kBall = 0.025, kHalf = 0.035, kMass = 0.4, kLift = 0.12;

/// Two fingers close on a block, lift it and hold it by friction alone; the lenses show where they press how much.
class Grasp : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		if (auto error = makeSolid(m_ball, "ball", makeSphereMesh(kBall, 4), 800, options)) return error;
		if (auto error = makeSolid(m_block, "block", makeBoxMesh({kHalf, kHalf, kHalf}), 1000, options)) return error;
		return std::nullopt;
	}
	double stepSize() const override { return 1e-3; }
	double duration() const override { return 3; }
	Viewpoint viewpoint() const override { return {{0, 0.11, 0}, 0.5, 0.4, 0.25}; }
	DrawChoice firstChoice() const override { return {.lenses = true}; }
	std::vector<Parameter> parameters() override
	{
		return {{"squeeze by", "mm", &m_squeeze, 0, 10, false, false}, {"friction", "", &m_friction, 0, 1, true, false}};
	}
	std::vector<Figure> figures() const override
	{
		const double weight = kMass * kGravity;
		const Vec3 left = world().contactForce(m_body, m_fingers[0]), right = world().contactForce(m_body, m_fingers[1]);
		const double squeeze = 0.5 * (left.x - right.x), height = double(m_body->getWorldTransform().getOrigin().y());
		return {{"weight that friction carries", "N", left.y + right.y, weight, 0.02 * weight},
				{"squeeze of a finger", "N", squeeze},
				{"fingers out of balance, sideways", "N", left.x + right.x, 0, 0.02 * weight},
				{"lifted", "mm", 1e3 * (height - kHalf), 1e3 * kLift, 2}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		w.addPlane({0, 1, 0}, 0, 0.5);
		BodySetup block;
		block.name = "block";
		block.mass = kMass;
		block.stiffness = 2e7;
		block.friction = 1;
		block.colour = bodyColour(1);
		block.X_WM.translation.y = kHalf;
		m_body = w.add(m_block, std::move(block));
		for (const int i : {0, 1})
		{
			BodySetup finger;
			finger.name = i ? "right finger" : "left finger";
			finger.mass = 0.1;
			finger.stiffness = 2e7;
			finger.friction = m_friction;
			finger.colour = bodyColour(0);
			finger.X_WM = target(i, 0);
			m_fingers[i] = w.add(m_ball, std::move(finger));
			if (!m_fingers[i]) return std::nullopt;
			m_fingers[i]->setGravity(btVector3(0, 0, 0));
			m_pulls[i].setFrequency(200);
			m_pulls[i].grab(m_fingers[i]);
		}
		return std::nullopt;
	}
	void beforeStep(double h) override
	{
		for (const int i : {0, 1})
		{
			// One that the user has taken follows him.
			if (hand().body() == m_fingers[i]) continue;
			m_pulls[i].setTarget(target(i, time()));
			m_pulls[i].pull(h);
		}
	}
	void decorate(const DrawChoice&, DrawList& list) override { list.gridCell = 0.02; }
	double arrowForce() const override { return 20; }
	double arrowLength() const override { return 0.05; }

private:
	Pose target(int i, double time) const
	{
		const double side = i ? 1 : -1, closed = side * (kHalf + kBall - 1e-3 * m_squeeze), open = side * (kHalf + kBall + 0.02);
		Pose X;
		X.translation = along({{0, {open, kHalf, 0}}, {0.7, {closed, kHalf, 0}}, {1, {closed, kHalf, 0}}, {2, {closed, kHalf + kLift, 0}}}, time);
		return X;
	}

	SolidPtr m_ball, m_block;
	btRigidBody *m_body = nullptr, *m_fingers[2] = {};
	HandPull m_pulls[2];
	double m_squeeze = 5, m_friction = 0.8;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeGrasp() { return std::make_unique<Grasp>(); }
}  // namespace browser
