// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "TestSupport/SceneFiles/SceneShapes.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kRing = 0.030, kTube = 0.006, kDensity = 7800;

Pose uprightFromZ() { return {rotationMatrix(quaternionFromRotationVector({-1.5707963267948966, 0, 0})), {}}; }

/// A sword falls through a ring and hangs in it by its guard.
class Sword : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		if (auto error = makeSolid(m_ring, "ring", transformed(makeTorusMesh(kRing, kTube), uprightFromZ()), 1000, options)) return error;
		if (auto error = makeSolid(m_sword, "sword", transformed(scenes::makeSwordMesh(), uprightFromZ()), 2000, options)) return error;
		return std::nullopt;
	}
	double stepSize() const override { return 1.0 / 480; }
	bool hasStockSide() const override { return true; }
	double duration() const override { return 2.5; }
	Viewpoint viewpoint() const override { return {{0, -0.06, 0}, 0.62, 0.5, 0.3}; }
	std::vector<Parameter> parameters() override
	{
		return {{"tilt at first", "deg", &m_tilt, 0, 12, true, false}, {"height at first", "m", &m_height, 0, 0.3, true, false}};
	}
	std::vector<Figure> figures() const override
	{
		const double weight = kDensity * m_sword->tree->volume * kGravity;
		const Pose X_WM = world().bodies()[1].X_WP() * inverse(m_sword->X_MP);
		const double below = scenes::SwordShape().blade - kTube;  // the lower side of the guard lies on the ring
		return {{"force of the ring", "N", world().contactForce(m_body).y, weight, 0.02 * weight},
			{"tip below the ring", "mm", -1e3 * X_WM.translation.y, 1e3 * below, 1.5},
			{"speed", "m/s", double(m_body->getLinearVelocity().length()), 0, 0.02}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		BodySetup ring;
		ring.name = "ring";
		ring.fixed = true;
		ring.stiffness = 1e9;
		ring.friction = 0.3;
		ring.colour = bodyColour(1);
		w.add(m_ring, std::move(ring));
		BodySetup sword;
		sword.name = "sword";
		sword.density = kDensity;
		sword.stiffness = 1e9;
		sword.friction = 0.3;
		sword.colour = bodyColour(0);
		sword.X_WM.translation = {0.004, m_height, 0.003};
		sword.X_WM.rotation = rotationMatrix(quaternionFromRotationVector({kDegree * m_tilt, 0.3, 0}));
		m_body = w.add(m_sword, std::move(sword));
		if (m_body) m_body->setDamping(btScalar(0.1), btScalar(0.9));
		return std::nullopt;
	}
	void decorate(const DrawChoice&, DrawList& list) override { list.groundHeight = -0.26, list.gridCell = 0.02; }
	double arrowForce() const override { return 2; }
	double arrowLength() const override { return 0.05; }

private:
	SolidPtr m_ring, m_sword;
	btRigidBody* m_body = nullptr;
	double m_tilt = 3, m_height = 0.02;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeSword() { return std::make_unique<Sword>(); }
}  // namespace browser
