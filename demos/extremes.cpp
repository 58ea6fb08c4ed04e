// SPDX-License-Identifier: Zlib
// Prints the page of the extremes as Markdown: stock Bullet, ours, and the reference, in the precision that this was built for.
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/ExtremePage.h"
#include "demos/scenes/Extremes/CubeTower.h"
#include "demos/scenes/Extremes/ExtremeRows.h"
#include "demos/scenes/Extremes/FloatingBodies.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

using namespace page;
using namespace scenes;

namespace
{
constexpr double kGravity = 9.81;

void printStiffness(const ExtremeSolid& cube)
{
	for (const double k : {1e2, 1e4, 1e6, 1e9})
		for (const double h : {1.0 / 30, 1.0 / 60, 1.0 / 240, 1e-3})
		{
			RestSetup setup;
			setup.k = k;
			setup.h = h;
			setup.drop = 0.05;
			setup.place = {0, -0.5, 0};
			setup.seconds = k < 1e3 ? 12 : 5;
			const RestOutcome rest = restOnPlane(Response::Volumetric, cube, setup);
			row(text("%g N/m, step %.2g s", k, h), "rigid",
				text("force off by %.1e, highest %+.1e edges", rest.modelRatio - 1, rest.highest), "the model's own curve");
		}
}

std::string describe(const TowerOutcome& tower)
{
	if (!tower.finite) return "not finite";
	if (tower.fellAfter < 0 && tower.drift > 0.5) return text("falls: drift %.1e edges", tower.drift);
	if (tower.fellAfter >= 0) return text("falls after %.2f s", tower.fellAfter);
	return text("stands, upper sinkage %.5f m, drift %.1e edges", tower.sinkage.back(), tower.drift);
}

void printTowers(const ExtremeSolid& cube)
{
	for (const bool defaults : {false, true})
		for (const double ratio : {1.0, 1e2, 1e4, 1e6})
		{
			TowerSetup setup;
			setup.topMass = ratio;
			ist::Pose upper;
			upper.translation = {0, 0.99, 0};
			if (!defaults) setup.k = ratio * kGravity / modelForceUp(cube, upper, cube, {}, 1);
			const TowerOutcome ours = stackCubes(Response::Volumetric, cube, setup);
			row(text("heavy on light 1:%g, %s", ratio, defaults ? "nothing set" : "k for 1 %"),
				describe(stackCubes(Response::Stock, cube, setup)), describe(ours),
				text("upper sinkage %.5f m by the model", ours.expected.back()));
		}
}

void printTallTower(const ExtremeSolid& cube, int cubes, bool plainBetween)
{
	TowerSetup setup;
	setup.cubes = cubes;
	setup.k = cubes * kGravity / 3e-4;
	setup.h = cubes > 10 ? 1.0 / 240 : 1.0 / 60;
	setup.seconds = cubes > 10 ? 10 : 20;
	setup.turn = 1.5707963267948966;
	setup.plainBetween = plainBetween;
	const TowerOutcome ours = stackCubes(Response::Volumetric, cube, setup);
	const std::string name = text("tower of %d, %s of %zu leaves, %g Hz, %g s (stock 60 s)", cubes,
		plainBetween ? "Bullet's boxes between cubes" : "cubes", cube.tree->law.slotCount(), 1 / setup.h, setup.seconds);
	setup.seconds = 60;
	row(name, describe(stackCubes(Response::Stock, cube, setup)),
		ours.fellAfter < 0 && ours.drift < 0.5 ? text("stands, drift %.1e edges, force of a layer off by %.0e", ours.drift, ours.forceError)
											   : describe(ours),
		text("needs a tilt stiffness of %.0f loads times edges; the model has %.0f at the foot, %.0f at the top", leastTiltStiffness(cubes),
			tiltStiffness(cube, 3e-4, plainBetween), tiltStiffness(cube, 3e-4 / cubes, plainBetween)));
}

void printTallTowers()
{
	const ist::Result<ExtremeSolid> fine = makeExtremeSolid(ist::makeBoxMesh({0.5, 0.5, 0.5}), 10000);
	const ist::Result<ExtremeSolid> finest = makeExtremeSolid(ist::makeBoxMesh({0.5, 0.5, 0.5}), 150000);
	if (!fine || !finest) return;
	for (const int cubes : {5, 10, 20}) printTallTower(fine.value(), cubes, false);
	printTallTower(finest.value(), 20, true);
	for (const double volume : {1e-2, 1e-3, 3e-4, 1e-4, 1e-5})
	{
		const auto both = [&](const ExtremeSolid& cube) {
			return text(
				"%.0f on its like and %.0f on a box in closed form", tiltStiffness(cube, volume), tiltStiffness(cube, volume, true));
		};
		row(text("tilt stiffness of a contact that carries k times %g m^3", volume), "rigid",
			text("10,000 spheres: %s; 150,000: %s", both(fine.value()).c_str(), both(finest.value()).c_str()),
			text("%.0f without gaps, in loads times edges", 1 / (12 * volume)));
	}
}

void printScales()
{
	for (const int power : {-10, -4, 0, 7, 10})
	{
		const double edge = std::ldexp(1, power);
		const ist::Result<ExtremeSolid> cube = makeExtremeSolid(ist::makeBoxMesh(0.5 * edge * ist::Vec3{1, 1, 1}), 500);
		if (!cube) continue;
		RestSetup setup = waterCube(edge, 12);
		setup.k = setup.mass * kGravity / (0.05 * edge * edge * edge);
		setup.dissipation = 5 / std::sqrt(edge);
		const RestOutcome ours = restOnPlane(Response::Volumetric, cube.value(), setup),
						  stock = restOnPlane(Response::Stock, cube.value(), setup);
		row(text("water cube of %.4g m, %.3g kg", edge, setup.mass), text("depth %+.4f edges", stock.depth / edge),
			text("depth %+.5f edges", ours.depth / edge),
			text("%+.5f by the model", modelSinkage(cube.value(), nullptr, setup.k, setup.mass * kGravity) / edge));
	}
}

void printFloating()
{
	constexpr double kPi = 3.14159265358979323846;
	const ist::Result<ExtremeSolid> box = makeExtremeSolid(ist::makeBoxMesh({0.5, 0.2, 0.8}), 10000),
									log = makeExtremeSolid(ist::makeBoxMesh({0.5, 0.5, 1}), 3000);
	if (!box || !log) return;
	const double draft = 0.2, GM = 1 / (12 * draft) - 0.1, inertiaPerMass = 1.16 / 12;
	const FloatOutcome out = floatBody(box.value(), 500, inertiaPerMass, 1.0 / 480);
	row("box of 1 x 0.4 x 1.6 m in water", "no fluid",
		text("draft %.4f m, heave %.4f s, roll %.4f s", out.draft, out.heavePeriod, out.rollPeriod),
		text(
			"%.4f m, %.4f s, %.4f s", draft, 2 * kPi * std::sqrt(draft / kGravity), 2 * kPi * std::sqrt(inertiaPerMass / (kGravity * GM))));
	for (const double share : {0.2013, 0.2213, 0.2413, 0.7787, 0.7987})
		row(text("square log of density share %.4f", share), "no fluid",
			text("rests at %.3f rad", restingTiltOfLog(log.value(), share, 1.0 / 120)),
			text("%.3f rad", wallSidedTilt(std::min(share, 1 - share))));
}

void printPlaces(const ExtremeSolid& cube)
{
	for (const double distance : {0.0, 1e3, 1e4, 1e6})
		for (const double depth : {0.02, 1e-3})
		{
			RestSetup setup;
			setup.k = kGravity / depth;
			setup.seconds = 8;
			setup.place = distance * ist::Vec3{1, 1, 1};
			setup.mayTurn = false;
			const double exact = modelSinkage(cube, nullptr, setup.k, kGravity);
			const RestOutcome ours = restOnPlane(Response::Volumetric, cube, setup), stock = restOnPlane(Response::Stock, cube, setup);
			row(text("%g m from the origin, designed depth %g m", distance, depth), text("depth %+.5f m", stock.depth),
				text("depth %+.5f m%s", ours.depth, ours.precisionLost ? ", precision lost reported" : ""),
				text("%+.5f m by the model", exact));
		}
}

void printRestitution(const ExtremeSolid& cube)
{
	for (const double dv : {0.05, 0.5, 5.0})
		for (const double hw : {0.006, 0.03})
			row(text("restitution, d v = %g, h omega = %g", dv, hw), "no such parameter",
				text("%.5f", bounce(cube, 1e3, dv, hw).restitution), text("%.5f, Hunt and Crossley", huntCrossleyRestitution(dv)));
}

void printCollisions(const ExtremeSolid& cube, int count)
{
	for (const double k : {1e5, 1e7})
		for (const double dissipation : {-1.0, 0.0})
		{
			double energy[2] = {}, momentum[2] = {}, physical = 0, numerical = 0, nameless = 0;
			for (int seed = 0; seed < count; ++seed)
				for (const Response response : {Response::Stock, Response::Volumetric})
				{
					CollisionSetup setup;
					setup.k = k;
					setup.dissipation = dissipation;
					const CollisionOutcome out = collide(response, cube, setup, uint64_t(seed));
					energy[int(response)] = std::max(energy[int(response)], out.energy);
					momentum[int(response)] = std::max(momentum[int(response)], out.momentum);
					if (response == Response::Stock) continue;
					physical += out.physical / count;
					numerical += out.numerical / count;
					nameless = std::max(nameless, std::fabs(1 - out.energy - out.physical - out.numerical));
				}
			const auto cell = [&](Response r) {
				return text("energy kept at most %.4f, momentum off %.1e", energy[int(r)], momentum[int(r)]);
			};
			row(text("%d collisions, 60 Hz, 4 m/s, k %g, %s", count, k, dissipation < 0 ? "default dissipation" : "no dissipation"),
				cell(Response::Stock),
				cell(Response::Volumetric) +
					text("; lost in the mean: physical %.3f, numerical %.3f, without a name at most %.0e", physical, numerical, nameless),
				"at most 1; 0; 0");
		}
}
}  // namespace

int main()
{
	const ist::Result<ExtremeSolid> cube = makeExtremeSolid(ist::makeBoxMesh({0.5, 0.5, 0.5}), 500);
	if (!cube)
	{
		std::fprintf(stderr, "extremes: %s\n", cube.error().message.c_str());
		return EXIT_FAILURE;
	}
	std::printf("# Extremes, %s precision\n\nUnit cubes of 500 spheres, mean gap %.4f m.\n\n", sizeof(btScalar) == 8 ? "double" : "single",
		cube.value().tree->meanGap);
	std::printf("| extreme | stock Bullet | ours | reference |\n|---|---|---|---|\n");
	printStiffness(cube.value());
	printTowers(cube.value());
	printTallTowers();
	printScales();
	printPlaces(cube.value());
	printFloating();
	printRestitution(cube.value());
	printCollisions(cube.value(), 100);
	printOverlaps(cube.value());
	printRest(cube.value());
	printFriction();
	printTumbling(cube.value());
	printThinPlate();
	printNotFinite(cube.value());
	printElsewhere();
	std::printf("\n## With nothing set\n\n| extreme | stock Bullet | ours | reference |\n|---|---|---|---|\n");
	printNothingSet(cube.value());
	return EXIT_SUCCESS;
}
