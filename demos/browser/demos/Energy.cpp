// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletHapticForce/World/btEnergyAudit.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr int kBalls = 4;

/// Bodies bounce, slide and spin until they rest, and all energy is accounted for.
class Energy : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		if (auto error = makeSolid(m_ball, "ball", makeSphereMesh(0.1, 4), 800, options)) return error;
		if (auto error = makeSolid(m_knot, "knot", knotMesh(0.35), 1000, options, true)) return error;
		return std::nullopt;
	}
	double stepSize() const override { return 1.0 / 480; }
	double duration() const override { return 2; }
	Viewpoint viewpoint() const override { return {{0, 0.15, 0}, 2.4, 0.5, 0.3}; }
	std::vector<Parameter> parameters() override
	{
		return {{"dissipation", "s/m", &m_dissipation, 0, 20, true, false}, {"friction", "", &m_friction, 0, 1, true, false}};
	}
	std::vector<Figure> figures() const override
	{
		const btEnergyBalance& t = m_audit->total();
		// Energy is conserved: what came in is still there, or was lost in a known way. Single precision rounds.
		return {{"energy that came in", "J", t.injected}, {"dissipated by contact, friction and damping", "J", t.physical},
			{"lost to the finite step", "J", t.numerical},
			{"unaccounted for, of what came in", "%", 100 * std::fabs(t.residual) / t.injected, 0, 0.1},
			{"sum of all names, of what came in", "%", 100 * (t.kinetic + t.potential + t.contact + t.physical + t.numerical) / t.injected,
				100, 0.1}};
	}
	std::vector<Curve> curves() const override
	{
		std::vector<Curve> curves = {m_kinetic, m_potential, m_contact, m_dissipated};
		for (Curve& curve : WorldDemo::curves()) curves.push_back(std::move(curve));
		return curves;
	}

protected:
	std::optional<Error> build() override
	{
		m_audit.reset();
		DemoWorld& w = addWorld();
		w.addPlane({0, 1, 0}, 0, 1);
		for (int i = 0; i <= kBalls; ++i)
		{
			BodySetup body;
			body.name = i < kBalls ? "ball " + std::to_string(i + 1) : "knot";
			body.stiffness = 1.5e7;
			body.dissipation = m_dissipation;
			body.friction = m_friction;
			body.colour = bodyColour(i);
			body.X_WM.translation = i < kBalls ? Vec3{0.28 * (i - 1.5), 0.5 + 0.15 * i, 0.1 * (i % 2)} : Vec3{0, 0.25, 0.05};
			btRigidBody* added = w.add(i < kBalls ? m_ball : m_knot, std::move(body));
			if (!added) return std::nullopt;
			if (i < kBalls) added->setLinearVelocity(btVector3(btScalar(0.36 - 0.24 * i), 0, 0));
			added->setAngularVelocity(btVector3(2, btScalar(3 * i), 0));
		}
		m_audit = std::make_unique<btEnergyAudit>(w.bullet(), w.volumetric()->contacts());
		for (Curve* curve : {&m_kinetic, &m_potential, &m_contact, &m_dissipated}) curve->values.clear();
		m_next = 0;
		return std::nullopt;
	}
	void beforeStep(double h) override { m_audit->beforeStep(h); }
	void afterStep(double) override
	{
		m_audit->afterStep();
		if (time() < m_next) return;
		m_next += 1.0 / 60;
		const btEnergyBalance& t = m_audit->total();
		const double values[] = {t.kinetic, t.potential, t.contact, t.physical + t.numerical};
		Curve* curves[] = {&m_kinetic, &m_potential, &m_contact, &m_dissipated};
		for (int i = 0; i < 4; ++i)
		{
			auto& line = curves[i]->values;
			if (line.size() == 600) line.erase(line.begin());
			line.push_back(float(values[i]));
		}
	}
	double arrowForce() const override { return 150; }
	double arrowLength() const override { return 0.25; }

private:
	SolidPtr m_ball, m_knot;
	std::unique_ptr<btEnergyAudit> m_audit;
	Curve m_kinetic{"kinetic", "J", {}}, m_potential{"potential", "J", {}}, m_contact{"in contacts", "J", {}},
		m_dissipated{"lost", "J", {}};
	double m_next = 0, m_dissipation = 0.4, m_friction = 0.4;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeEnergy() { return std::make_unique<Energy>(); }
}  // namespace browser
