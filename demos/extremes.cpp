// SPDX-License-Identifier: Zlib
// Prints the page of the extremes as Markdown: stock Bullet, ours, and the reference, in the precision that this was built for.
#include "BulletISTCollision/Core/MeshShapes.h"
#include "demos/scenes/ExtremeRows.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <string>

using namespace scenes;

namespace
{
constexpr double kGravity = 9.81;

__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...)
{
	char buffer[256];
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
			row(text("%g N/m, step %.2g s", k, h), "rigid", text("force off by %.1e, highest %+.1e edges", rest.modelRatio - 1, rest.highest),
				"the model's own curve");
		}
}

std::string describe(const TowerOutcome& tower)
{
	if (!tower.finite) return "not finite";
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
			row(text("heavy on light 1:%g, %s", ratio, defaults ? "nothing set" : "k for 1 %"), describe(stackCubes(Response::Stock, cube, setup)),
				describe(ours), text("upper sinkage %.5f m by the model", ours.expected.back()));
		}
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
				text("depth %+.5f m", ours.depth), text("%+.5f m by the model", exact));
		}
}

void printRestitution(const ExtremeSolid& cube)
{
	for (const double dv : {0.05, 0.5, 5.0})
		for (const double hw : {0.006, 0.03})
			row(text("restitution, d v = %g, h omega = %g", dv, hw), "no such parameter", text("%.5f", bounce(cube, 1e3, dv, hw).restitution),
				text("%.5f, Hunt and Crossley", huntCrossleyRestitution(dv)));
}

void printCollisions(const ExtremeSolid& cube, int count)
{
	for (const double k : {1e5, 1e7})
		for (const double dissipation : {-1.0, 0.0})
		{
			double energy[2] = {}, momentum[2] = {};
			for (int seed = 0; seed < count; ++seed)
				for (const Response response : {Response::Stock, Response::Volumetric})
				{
					CollisionSetup setup;
					setup.k = k;
					setup.dissipation = dissipation;
					const CollisionOutcome out = collide(response, cube, setup, uint64_t(seed));
					energy[int(response)] = std::max(energy[int(response)], out.energy);
					momentum[int(response)] = std::max(momentum[int(response)], out.momentum);
				}
			const auto cell = [&](Response r) { return text("energy kept at most %.4f, momentum off %.1e", energy[int(r)], momentum[int(r)]); };
			row(text("%d collisions, 60 Hz, 4 m/s, k %g, %s", count, k, dissipation < 0 ? "default dissipation" : "no dissipation"),
				cell(Response::Stock), cell(Response::Volumetric), "at most 1; 0");
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
	printPlaces(cube.value());
	printRestitution(cube.value());
	printCollisions(cube.value(), 100);
	return EXIT_SUCCESS;
}
