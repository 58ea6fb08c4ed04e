// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kMass = 2, kWatched = 0.5;

/// Two slabs lie on a slope, one rough, one smooth.
class Incline : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		if (auto error = makeSolid(m_slab, "slab", makeBoxMesh({0.15, 0.03, 0.1}), 800, options)) return error;
		return std::nullopt;
	}
	bool hasStockSide() const override { return true; }
	double duration() const override { return 1.5; }
	Viewpoint viewpoint() const override { return {{0.5, -0.2, 0}, 3.0, 0.25, 0.25}; }
	std::vector<Parameter> parameters() override
	{
		return {{"slope", "deg", &m_degrees, 1, 45, true, false}, {"friction of the rough one", "", &m_rough, 0, 1.2, true, false},
			{"friction of the smooth one", "", &m_smooth, 0, 1.2, true, false}};
	}
	std::vector<Figure> figures() const override { return {figure("rough slab", 0, m_rough), figure("smooth slab", 1, m_smooth)}; }

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		w.addPlane(normal(), 0, 1);
		const double sunk = 0.002, stiffness = kMass * kGravity * std::cos(angle()) / (0.3 * 0.2 * sunk);
		for (const bool smooth : {false, true})
		{
			BodySetup slab;
			slab.name = smooth ? "smooth slab" : "rough slab";
			slab.mass = kMass;
			slab.stiffness = stiffness;
			slab.friction = smooth ? m_smooth : m_rough;
			slab.colour = bodyColour(smooth ? 0 : 6);
			slab.X_WM.rotation = rotationMatrix(quaternionFromRotationVector({0, 0, -angle()}));
			slab.X_WM.translation = (0.03 - sunk) * normal() - 0.25 * downhill() + Vec3{0, 0, smooth ? 0.18 : -0.18};
			m_bodies[smooth] = w.add(m_slab, std::move(slab));
			m_before[smooth] = {};
		}
		return std::nullopt;
	}
	void afterStep(double) override
	{
		if (std::fabs(time() - (duration() - kWatched)) > 0.6 * stepSize()) return;
		for (int i = 0; i < 2; ++i) m_before[i] = toVec3(m_bodies[i]->getLinearVelocity());
		m_watchedFrom = time();
	}
	void decorate(const DrawChoice&, DrawList& list) override { list.groundNormal = normal(), list.gridCell = 0.1; }
	double arrowForce() const override { return kMass * kGravity; }
	double arrowLength() const override { return 0.2; }

private:
	double angle() const { return kDegree * m_degrees; }
	Vec3 normal() const { return {std::sin(angle()), std::cos(angle()), 0}; }
	Vec3 downhill() const { return {std::cos(angle()), -std::sin(angle()), 0}; }
	/// Acceleration by Coulomb's law: g (sin - mu cos), or 0.
	Figure figure(const char* name, int i, double friction) const
	{
		const double exact = std::max(0.0, kGravity * (std::sin(angle()) - friction * std::cos(angle())));
		const double took = time() - m_watchedFrom, gained = dot(toVec3(m_bodies[i]->getLinearVelocity()) - m_before[i], downhill());
		return {std::string(name) + ": acceleration", "m/s^2", took > 0 ? gained / took : 0, exact, std::max(0.015 * exact, 0.005)};
	}

	SolidPtr m_slab;
	btRigidBody* m_bodies[2] = {};
	Vec3 m_before[2];
	double m_watchedFrom = 0, m_degrees = 25, m_rough = 0.6, m_smooth = 0.3;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeIncline() { return std::make_unique<Incline>(); }
}  // namespace browser
