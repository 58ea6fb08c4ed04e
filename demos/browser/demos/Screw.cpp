// SPDX-License-Identifier: Zlib
#include "demos/browser/base/Threads.h"
#include "demos/browser/base/WorldDemo.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kPi = 3.14159265358979323846, kGravity = 9.81, kDensity = 7800, kRubbing = 0.6;
constexpr double kLength = 0.1, kNut = 0.045, kClearance = 4e-4, kHead = 0.032, kHeadHeight = 0.014, kApart = 0.055;
constexpr Thread kThread;

/// Two screws in their nuts: one without friction runs down under its own weight, the other is self-locking. The dissipation is the
/// default one, which does not brake sliding along a surface, however curved.
class Screw : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		if (auto error = makeSolid(m_nut, "nut", nut(kThread, kClearance, 0.07, kNut), 12000, options)) return error;
		return makeSolid(m_screw, "screw", screw(kThread, kLength, kHead, kHeadHeight), 12000, options);
	}
	double stepSize() const override { return 1.0 / 240; }
	bool hasStockSide() const override { return true; }
	double duration() const override { return 0.3; }
	Viewpoint viewpoint() const override { return {{0, 0.02, 0}, 0.42, 0.3, 0.4}; }
	std::vector<Parameter> parameters() override { return {{"friction of the second", "", &m_rubbing, 0, 1, true, false}}; }
	std::vector<Figure> figures() const override
	{
		if (!m_free) return {};
		const double turnsToWay = 2 * kPi / kThread.lead, inertia = double(m_free->getLocalInertia().y()) * double(m_free->getInvMass());
		const double fall = kGravity / (1 + inertia * turnsToWay * turnsToWay), took = time() - m_from;
		return {{"way of the free one for a turn", "mm", m_turned > 0 ? 1e3 * 2 * kPi * m_sunk / m_turned : 0, 1e3 * kThread.lead,
					5 * kThread.lead},
			{"its acceleration, from its spin", "m/s^2", took > 0 ? m_gained / took / turnsToWay : 0, fall, 0.01 * fall},
			{"turn of the one that locks itself", "deg", m_slipped / kDegree, 0, 0.5}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		m_free = addPair(w, -kApart, 0, 0);
		m_locked = addPair(w, kApart, m_rubbing, 6);
		m_turned = m_sunk = m_gained = m_slipped = m_from = 0;
		return std::nullopt;
	}
	void afterStep(double h) override
	{
		if (time() < kSettling) return;
		// The thread is right-handed: a sinking screw rotates about -y.
		const double turning = -double(m_free->getAngularVelocity().y()), sinking = -double(m_free->getLinearVelocity().y());
		if (m_from == 0) m_from = time(), m_start = turning;
		m_turned += h * turning;
		m_sunk += h * sinking;
		m_gained = turning - m_start;
		m_slipped += h * std::fabs(double(m_locked->getAngularVelocity().y()));
	}
	void decorate(const DrawChoice&, DrawList& list) override { list.groundHeight = -0.09, list.gridCell = 0.02; }
	double arrowForce() const override { return 10; }
	double arrowLength() const override { return 0.05; }

private:
	static constexpr double kStiffness = 4e7;  ///< [Pa/m]
	static constexpr double kSettling = 0.15;  ///< time until the screws lie on their flanks [s]

	btRigidBody* addPair(DemoWorld& w, double x, double friction, int colour)
	{
		BodySetup held;
		held.stiffness = kStiffness;
		held.friction = friction;
		held.name = friction > 0 ? "rough nut" : "smooth nut";
		held.fixed = true;
		held.colour = {0.62f, 0.68f, 0.75f};
		held.X_WM.translation = {x, 0, 0};
		w.add(m_nut, std::move(held));
		BodySetup thread;
		thread.stiffness = kStiffness;
		thread.friction = friction;
		thread.name = friction > 0 ? "rough screw" : "smooth screw";
		thread.density = kDensity;
		thread.colour = bodyColour(colour);
		thread.X_WM.translation = {x, 2 * kThread.lead, 0};  // the shift is a number of whole turns, so the threads stand in the gaps
		return w.add(m_screw, std::move(thread));
	}

	SolidPtr m_nut, m_screw;
	btRigidBody *m_free = nullptr, *m_locked = nullptr;
	double m_turned = 0, m_sunk = 0, m_gained = 0, m_slipped = 0, m_from = 0, m_start = 0, m_rubbing = kRubbing;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeScrew() { return std::make_unique<Screw>(); }
}  // namespace browser
