// SPDX-License-Identifier: Zlib
#include "demos/ExtremePage.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "demos/scenes/Extremes/ExtremeMotions.h"
#include "demos/scenes/Extremes/ExtremeRows.h"
#include "demos/scenes/Truth/PenetrationWork.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>

using namespace scenes;

namespace page
{
namespace
{
constexpr double kGravity = 9.81;
}

std::string text(const char* format, ...)
{
	char buffer[320];
	va_list arguments;
	va_start(arguments, format);
	std::vsnprintf(buffer, sizeof(buffer), format, arguments);
	va_end(arguments);
	return buffer;
}

void row(const std::string& extreme, const std::string& stock, const std::string& ours, const std::string& reference)
{
	std::printf("| %s | %s | %s | %s |\n", extreme.c_str(), stock.c_str(), ours.c_str(), reference.c_str());
	std::fflush(stdout);
}

void printOverlaps(const ExtremeSolid& cube)
{
	ist::QueryWorkspace workspace;
	const ist::Vec3 direction = ist::normalized({0.3, 1, -0.2});
	ist::Pose X;
	X.rotation = ist::rotationMatrix(ist::quaternionFromRotationVector({0.4, 0.1, 0.7}));
	const auto at = [&](double distance) {
		X.translation = distance * direction;
		return ist::queryOverlap(*cube.tree, *cube.tree, X, workspace).total;
	};
	for (const double share : {1e-2, 1e-6, 1e-12})
	{
		double low = 0.3, high = 2;
		for (int i = 0; i < 60; ++i) (at(0.5 * (low + high)).volume > share * cube.tree->volume ? low : high) = 0.5 * (low + high);
		const double volume = at(low).volume, exact = ist::queryOverlapBruteForce(*cube.tree, *cube.tree, X).total.volume;
		row(text("overlap of %.0e of the volume", share), "points, no volume", text("off by %.0e", std::fabs(volume / exact - 1)),
			"all pairs in double");
	}
	X.rotation = ist::Pose().rotation;
	double peak = 0;
	for (int i = 0; i <= 100; ++i) peak = std::max(peak, norm(ist::pressureWrench(at(0.018 * i), {1, 0.5, 0.5}).force));
	row("identical bodies in one place", "no direction",
		text("force %.0e of the peak", norm(ist::pressureWrench(at(0), {1, 0.5, 0.5}).force) / peak), "0");
}

void printRest(const ExtremeSolid& cube)
{
	RestSetup setup;
	setup.k = kGravity / 0.05;
	setup.seconds = 3600;
	setup.place = {0, -0.5, 0};
	const RestOutcome ours = restOnPlane(Response::Volumetric, cube, setup), stock = restOnPlane(Response::Stock, cube, setup);
	const auto describe = [&](const RestOutcome& rest) {
		return text("kinetic energy %.0e of m g d0, moves %.0e edges in the last half", rest.kinetic / (kGravity * 0.05), rest.creep);
	};
	row("an hour at rest, sleeping off", describe(stock), describe(ours), "0, 0");
}

void printFriction()
{
	const ist::Result<ExtremeSolid> slab = makeExtremeSolid(ist::makeBoxMesh({0.5, 0.1, 0.5}), 500),
									disc = makeExtremeSolid(ist::makeCylinderMesh(0.5, 0.1, 96), 2000);
	const ist::Result<ExtremeSolid> rod = makeExtremeSolid(ist::makeBoxMesh({0.03, 0.5, 0.03}), 1000);
	if (!slab || !disc || !rod) return;
	const double mu = 0.5, critical = std::atan(mu);
	for (const double f : {0.5, 0.9, 0.99})
		row(text("slope of %g of the critical angle, 60 Hz, 10 s", f), "not run",
			text("creeps %.0e m", slideOnSlope(slab.value(), mu, f * critical, 0, 500, 1.0 / 60).creep), "0");
	for (const double f : {1.01, 1.1, 2.0})
	{
		double least = 1e300, most = 0, across = 0;
		for (const double heading : {0.0, 0.4, 1.3, 2.5, 4.0})
		{
			const SlopeOutcome out = slideOnSlope(slab.value(), mu, f * critical, heading, 500, 1.0 / 60);
			least = std::min(least, out.acceleration);
			most = std::max(most, out.acceleration);
			across = std::max(across, std::fabs(out.across));
		}
		row(text("slope of %g of it, five directions", f), "not run", text("%.5f to %.5f m/s^2, %.0e across", least, most, across),
			text("%.5f, Coulomb", kGravity * (std::sin(f * critical) - mu * std::cos(f * critical))));
	}
	row("spinning disc, 240 Hz", "no drilling friction", text("stops after %.4f", drillingStopTime(disc.value(), 0.5, 0.5, 400, 1.0 / 240)),
		"1, closed form");
	for (const double friction : {0.5, 1.5, 3.0})
	{
		const auto describe = [](const RodOutcome& out) {
			return out.finite
				? text("energy rises by %.1e m g length, ends %.3f lengths deep at %.0e m/s", out.energyGain, out.deepest, out.speed)
				: "not finite";
		};
		row(text("rod sliding on its tip, friction %g, 2 m/s, 240 Hz (Painleve)", friction),
			describe(slideRodOnItsTip(Response::Stock, rod.value(), friction, 2, 1.0 / 240)),
			describe(slideRodOnItsTip(Response::Volumetric, rod.value(), friction, 2, 1.0 / 240)), "finite, no rise");
	}
}

void printTumbling(const ExtremeSolid& cube)
{
	for (const double rate : {60.0, 1000.0})
	{
		const auto describe = [](const TumbleOutcome& out) {
			return text("keeps %.3f of its energy, turns over %.3f of its momentum", out.energy, out.momentum);
		};
		row(text("inertia 1 : 2 : 5 about the middle axis, %g Hz, 60 s", rate), describe(tumble(Response::Stock, cube, 1 / rate, 60)),
			describe(tumble(Response::Volumetric, cube, 1 / rate, 60)), "1, 0; Bullet's integrator in both");
	}
}

void printThinPlate()
{
	const ist::Result<ExtremeSolid> plate = makeExtremeSolid(ist::makeBoxMesh({0.5, 0.0005, 0.5}), 2000),
									cube = makeExtremeSolid(ist::makeBoxMesh({0.05, 0.05, 0.05}), 300);
	if (!plate || !cube) return;
	ist::QueryWorkspace workspace;
	ist::Pose X;
	X.translation = {0, -0.07, 0};
	for (const double k : {1e6, 1e10})
	{
		const auto work = penetrationWork(*cube.value().tree, *plate.value().tree, X, {0, -1, 0}, 0.075, {k, 0.5, 0.5}, workspace, 1000);
		const std::string reference = work ? text("face on, in small steps, holds 1 kg up to %.3g m/s", std::sqrt(2 * work.value().energy))
										   : "";
		for (const double speed : {1.0, 10.0, 100.0})
		{
			const ShotOutcome ours = shootAtPlate(Response::Volumetric, plate.value(), cube.value(), speed, 1.0 / 60, k, 12);
			const ShotOutcome stock = shootAtPlate(Response::Stock, plate.value(), cube.value(), speed, 1.0 / 60, k, 12);
			row(text("plate of 1 mm, %g m/s, 60 Hz, k %g, 12 shots", speed, k), text("%d through, none reported", stock.through),
				text("%d through, %d of them unreported; %d held, %d of them reported as too fast to be sure", ours.through,
					ours.unreported, ours.held, ours.tooFast),
				reference);
		}
	}
}

void printNotFinite(const ExtremeSolid& cube)
{
	std::string cells[2];
	for (const Response response : {Response::Stock, Response::Volumetric})
	{
		ExtremeWorld world(response);
		world.addFloor();
		btRigidBody* sound = world.add(cube, 1, 1.0 / 6, transformOf({0, 0.49, 0}), 1e3);
		btRigidBody* poisoned = world.add(cube, 1, 1.0 / 6, transformOf({0, 1.47, 0}), 1e3);
		for (int i = 0; i < 60; ++i)
		{
			if (i == 30) poisoned->setLinearVelocity(btVector3(0, std::numeric_limits<btScalar>::quiet_NaN(), 0));
			world.step(1.0 / 60);
		}
		const bool finite = std::isfinite(double(sound->getWorldTransform().getOrigin().length2()));
		cells[int(response)] = finite ? "the neighbour below stays finite" : "the neighbour below is poisoned";
	}
	row("a velocity that is not a number, in a stack", cells[0], cells[1], "neighbours untouched");
}

void printElsewhere()
{
	std::printf("\n| extreme | where it is measured or tested |\n|---|---|\n");
	const auto other = [](const char* extreme, const char* where) { std::printf("| %s | %s |\n", extreme, where); };
	other("float and double", "this page, from both programs");
	other("1 to 1,000 bodies, up to 30,000 pairs", "`bench_scenes`, `bench_query`; no allocation: `ctest -R Alloc`");
	other("zero mass, kinematic, static, locked axes, sensors, deletion", "`ctest -R scenario`");
	other("explicit limit of the paper's law", "`ctest -R PaperLaw`");
	other("ripple, contact breaking", "`haptic_demos --demo continuity`");
	other("Z-width, passivity", "`devicebridge zwidth`");
	other("slow, late and dead worlds", "`ctest -R Decoupled`");
	other("device faults, random operations", "`ctest -R \"Fault|Fuzz|Safety\"`");
	other("needles, shells, trees of one sphere", "`ctest -R \"SpherePacker|TreeBuilder|OverlapQuery\"`");
}
}  // namespace page
