// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/FloatingBodies.h"

#include <cmath>
#include <limits>

namespace scenes
{
namespace
{
constexpr double kGravity = 9.81;

struct Pond
{
	ExtremeWorld world{Response::Volumetric, kGravity};
	btRigidBody* body = nullptr;
	ist::Vec3 place{1, 0, -2};

	/// If the materials are refused, `body` stays null.
	Pond(const ExtremeSolid& solid, double mass, double inertia, double height, double tilt, double dissipation)
	{
		btRigidBody* water = world.addFloor();
		water->setFriction(0);
		btContactMaterial fluid = btContactMaterial::fluid(kWater);
		fluid.dissipation = dissipation;
		if (world.volumetric().materials().set(water, fluid)) return;
		place.y = height;
		body = world.add(solid, mass, inertia, transformOf(place, {0, 0, tilt}));
	}
	double height() const { return double(body->getWorldTransform().getOrigin().y()); }
	double tilt() const
	{
		const btMatrix3x3& R = body->getWorldTransform().getBasis();
		return std::atan2(double(R[1][0]), double(R[0][0]));
	}
};

/// Mean time between zero crossings in the same direction [s]; not finite with fewer than two crossings.
template <class Signal> double period(Pond& pond, double h, int steps, const Signal& signal)
{
	double first = 0, last = 0, before = signal();
	int crossings = 0;
	for (int i = 1; i <= steps; ++i)
	{
		pond.world.step(h);
		const double now = signal();
		if (before < 0 && now >= 0)
		{
			last = h * (i - 1 + before / (before - now));
			if (crossings++ == 0) first = last;
		}
		before = now;
	}
	return crossings > 1 ? (last - first) / (crossings - 1) : std::numeric_limits<double>::quiet_NaN();
}
}  // namespace

FloatOutcome floatBody(const ExtremeSolid& solid, double density, double inertiaPerMass, double h)
{
	const double mass = density * solid.tree->volume, inertia = inertiaPerMass * mass;
	const double below = -ist::bounds(solid.mesh).lower.y, expected = density / kWater * ist::bounds(solid.mesh).size().y;
	const int steps = int(6 / h);
	FloatOutcome out;
	Pond resting(solid, mass, inertia, below - 0.8 * expected, 0, 1);
	if (!resting.body) return out;
	for (int i = 0; i < steps; ++i) resting.world.step(h);
	out.draft = below - resting.height();

	Pond heaving(solid, mass, inertia, below - 0.75 * out.draft, 0, 0);
	heaving.body->setAngularFactor(btScalar(0));
	out.heavePeriod = period(heaving, h, steps, [&] { return heaving.height() - (below - out.draft); });
	Pond rolling(solid, mass, inertia, below - out.draft, 0.08, 0);
	const double upright = resting.tilt();
	out.rollPeriod = period(rolling, h, steps, [&] { return rolling.tilt() - upright; });
	return out;
}

double restingTiltOfLog(const ExtremeSolid& log, double share, double h)
{
	const double width = ist::bounds(log.mesh).size().x, mass = share * kWater * log.tree->volume;
	Pond pond(log, mass, mass * width * width / 6, width * (0.5 - share), 0.05, 0.3);
	if (!pond.body) return 1e300;
	pond.body->setLinearFactor(btVector3(0, 1, 0));
	pond.body->setAngularFactor(btVector3(0, 0, 1));
	for (int i = 0; i < int(30 * std::sqrt(width) / h); ++i) pond.world.step(h);
	return std::fabs(pond.tilt());
}

double wallSidedTilt(double share)
{
	const double BM = 1 / (12 * share), GM = BM - 0.5 * (1 - share);
	return GM >= 0 ? 0 : std::atan(std::sqrt(-2 * GM / BM));
}
}  // namespace scenes
