// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"
#include "demos/browser/drawing/Turned.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletDynamics/ConstraintSolver/btHingeConstraint.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr int kDriver = 14, kDriven = 21;
constexpr double kModule = 0.01, kHalfWidth = 0.012, kSpeed = 4, kLoad = 0.6;  // [rad/s, N m]

/// One gear drives another against a load, tooth by tooth.
class Gears : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		for (const int i : {0, 1})
		{
			if (auto error = makeSolid(
					m_solids[i], i ? "driven" : "driver", gear(i ? kDriven : kDriver, kModule, kHalfWidth, 4e-4), i ? 2000 : 1500, options))
				return error;
		}
		return std::nullopt;
	}
	double stepSize() const override { return 1e-3; }
	bool hasStockSide() const override { return true; }
	double duration() const override { return 2.2; }
	Viewpoint viewpoint() const override { return {{0, 0, 0}, 0.75, 0.35, 1.0}; }
	std::vector<Parameter> parameters() override
	{
		return {{"load", "N m", &m_load, 0, 3, false, false}, {"speed", "rad/s", &m_speed, 0.5, 10, false, false}};
	}
	std::vector<Figure> figures() const override
	{
		const double exact = -double(kDriver) / kDriven, took = time() - m_from;
		return {{"ratio of the angles turned", "", m_angle[0] != 0 ? m_angle[1] / m_angle[0] : 0, exact, 0.01 * std::fabs(exact)},
			{"mean torque of the driver, losses included", "N m", took > 0 ? m_work / took : 0, m_load * kDriver / kDriven,
				0.1 * m_load + 0.01}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld({0, 0, 0});
		const double radii[] = {0.5 * kModule * kDriver, 0.5 * kModule * kDriven};
		for (const int i : {0, 1})
		{
			BodySetup setup;
			setup.name = i ? "driven gear" : "driver";
			setup.density = 7800;
			setup.stiffness = 2e9;
			setup.friction = 0;
			setup.colour = bodyColour(i ? 0 : 1);
			// A tooth of one gear faces a gap of the other.
			setup.X_WM.rotation = rotationMatrix(
				quaternionFromRotationVector({0, i ? 3.14159265358979323846 * (1 + 1.0 / kDriven) : 0, 0}));
			setup.X_WM.translation = {i ? radii[0] : -radii[1], 0, 0};
			m_bodies[i] = w.add(m_solids[i], std::move(setup));
			if (!m_bodies[i]) return std::nullopt;
			auto axle = std::make_unique<btHingeConstraint>(*m_bodies[i], btVector3(0, 0, 0), btVector3(0, 1, 0));
			w.addConstraint(std::move(axle));
			m_angle[i] = 0;
		}
		m_work = m_from = m_held = 0;
		return std::nullopt;
	}
	void beforeStep(double h) override
	{
		// One gear has a motor that holds its speed, the other one a brake.
		const double inertia = 1 / double(m_bodies[0]->getInvInertiaTensorWorld()[1][1]), gain = 0.2 * inertia / h;
		const double wanted = m_speed * std::min(1.0, 4 * time()), ahead = wanted - double(m_bodies[0]->getAngularVelocity().y());
		m_held += 10 * ahead * gain * h;
		m_torque = gain * ahead + m_held;
		m_bodies[0]->applyTorque(btVector3(0, btScalar(m_torque), 0));
		const double turns = double(m_bodies[1]->getAngularVelocity().y());
		m_bodies[1]->applyTorque(btVector3(0, btScalar(-m_load * std::tanh(turns / 0.05)), 0));
	}
	void afterStep(double h) override
	{
		if (time() < 0.7)
		{
			m_from = time();
			return;
		}
		for (const int i : {0, 1}) m_angle[i] += h * double(m_bodies[i]->getAngularVelocity().y());
		m_work += h * m_torque;
	}
	void decorate(const DrawChoice&, DrawList& list) override { list.groundHeight = -0.06, list.gridCell = 0.02; }
	double arrowForce() const override { return 10; }
	double arrowLength() const override { return 0.06; }

private:
	SolidPtr m_solids[2];
	btRigidBody* m_bodies[2] = {};
	double m_angle[2] = {}, m_work = 0, m_from = 0, m_torque = 0, m_held = 0, m_load = kLoad, m_speed = kSpeed;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeGears() { return std::make_unique<Gears>(); }
}  // namespace browser
