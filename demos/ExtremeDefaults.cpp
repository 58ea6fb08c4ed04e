// SPDX-License-Identifier: Zlib
// The extremes again with nothing set: neither stiffness nor dissipation.
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/ExtremePage.h"
#include "demos/scenes/Extremes/CubeTower.h"
#include "demos/scenes/Extremes/ExtremeRows.h"

#include <algorithm>
#include <cmath>

using namespace scenes;

namespace page
{
namespace
{
constexpr double kGravity = 9.81;

std::string describe(const RestOutcome& out, double edge)
{
	if (!out.finite) return "not finite";
	return text("depth %+.5f edges, creep %.0e, impulses off by %.0e, energy gained %.0e%s", out.depth / edge, out.creep,
		std::fabs(out.impulseRatio - 1), std::max(0.0, out.energyGain), out.precisionLost ? ", precision lost reported" : "");
}

std::string describe(const TowerOutcome& out)
{
	if (!out.finite) return "not finite";
	if (out.fellAfter >= 0) return text("falls after %.2f s", out.fellAfter);
	return text("stands, deepest contact %.5f m, drift %.0e edges", *std::max_element(out.sinkage.begin(), out.sinkage.end()), out.drift);
}

void printRestAtSteps(const ExtremeSolid& cube)
{
	for (const double h : {1.0 / 30, 1.0 / 60, 1.0 / 240, 1e-3})
	{
		RestSetup setup;
		setup.k = 0;
		setup.h = h;
		setup.drop = 0.05;
		setup.seconds = 5;
		row(text("cube dropped from 5 cm, step %.2g s", h), describe(restOnPlane(Response::Stock, cube, setup), 1),
			describe(restOnPlane(Response::Volumetric, cube, setup), 1), "0.0002 to 0.005; 0; 0; 0");
	}
}

void printScales()
{
	for (const int power : {-10, -4, 0, 7, 10})
	{
		const double edge = std::ldexp(1, power);
		const ist::Result<ExtremeSolid> cube = makeExtremeSolid(ist::makeBoxMesh(0.5 * edge * ist::Vec3{1, 1, 1}), 500);
		if (!cube) continue;
		const RestSetup setup = waterCube(edge, 6);
		row(text("water cube of %.4g m, %.3g kg", edge, setup.mass), describe(restOnPlane(Response::Stock, cube.value(), setup), edge),
			describe(restOnPlane(Response::Volumetric, cube.value(), setup), edge), "0.0002 to 0.005; 0; 0; 0");
	}
}

void printPlaces(const ExtremeSolid& cube)
{
	for (const double distance : {0.0, 1e3, 1e4, 1e6})
	{
		RestSetup setup;
		setup.k = 0;
		setup.seconds = 5;
		setup.place = distance * ist::Vec3{1, 1, 1};
		row(text("%g m from the origin", distance), describe(restOnPlane(Response::Stock, cube, setup), 1),
			describe(restOnPlane(Response::Volumetric, cube, setup), 1), "0.0002 to 0.005; 0; 0; 0");
	}
}

void printTowers(const ExtremeSolid& cube)
{
	for (const auto& [cubes, rate] : {std::pair{3, 60}, {5, 60}, {10, 60}, {10, 240}, {20, 240}})
	{
		TowerSetup setup;
		setup.cubes = cubes;
		setup.h = 1.0 / rate;
		setup.seconds = 20;
		row(text("tower of %d, %d Hz, 20 s", cubes, rate), describe(stackCubes(Response::Stock, cube, setup)),
			describe(stackCubes(Response::Volumetric, cube, setup)), "stands");
	}
}

void printCollisions(const ExtremeSolid& cube)
{
	constexpr int kCount = 100;
	for (const double speed : {1.0, 4.0, 20.0})
	{
		double energy[2] = {}, momentum[2] = {}, deepest = 0;
		for (int seed = 0; seed < kCount; ++seed)
			for (const Response response : {Response::Stock, Response::Volumetric})
			{
				CollisionSetup setup;
				setup.k = 0;
				setup.speed = speed;
				const CollisionOutcome out = collide(response, cube, setup, uint64_t(seed));
				energy[int(response)] = std::max(energy[int(response)], out.energy);
				momentum[int(response)] = std::max(momentum[int(response)], out.momentum);
				if (response == Response::Volumetric) deepest = std::max(deepest, out.deepest);
			}
		const auto cell = [&](Response r) { return text("energy kept at most %.4f, momentum off %.1e", energy[int(r)], momentum[int(r)]); };
		row(text("%d collisions in free flight, 60 Hz, %g m/s", kCount, speed), cell(Response::Stock),
			cell(Response::Volumetric) + text(", overlap at most %.4f of the volume", deepest), "at most 1; 0");
	}
}

void printSliding()
{
	const ist::Result<ExtremeSolid> slab = makeExtremeSolid(ist::makeBoxMesh({0.5, 0.1, 0.5}), 500),
									disc = makeExtremeSolid(ist::makeCylinderMesh(0.5, 0.1, 96), 2000);
	if (!slab || !disc) return;
	const double mu = 0.5, critical = std::atan(mu);
	for (const double f : {0.9, 0.99})
		row(text("slope of %g of the critical angle, 60 Hz, 10 s", f), "not run",
			text("creeps %.0e m", slideOnSlope(slab.value(), mu, f * critical, 0, 0, 1.0 / 60).creep), "0");
	for (const double f : {1.01, 1.1, 2.0})
		row(text("slope of %g of it", f), "not run",
			text("%.5f m/s^2", slideOnSlope(slab.value(), mu, f * critical, 0.4, 0, 1.0 / 60).acceleration),
			text("%.5f, Coulomb", kGravity * (std::sin(f * critical) - mu * std::cos(f * critical))));
	row("spinning disc, 240 Hz", "no drilling friction", text("stops after %.4f", drillingStopTime(disc.value(), 0.5, 0.5, 0, 1.0 / 240)),
		"1, closed form");
}
}  // namespace

void printNothingSet(const ExtremeSolid& cube)
{
	printRestAtSteps(cube);
	printTowers(cube);
	printScales();
	printPlaces(cube);
	printCollisions(cube);
	printSliding();
}
}  // namespace page
