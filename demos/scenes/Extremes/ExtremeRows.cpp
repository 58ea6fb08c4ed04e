// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/ExtremeRows.h"

#include "BulletHapticForce/World/btEnergyAudit.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "demos/scenes/Truth/MeshBelowPlane.h"
#include "demos/scenes/Truth/PairMotion.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

namespace scenes
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

bool isFinite(const btRigidBody* body)
{
	const btVector3 sum = body->getWorldTransform().getOrigin() + body->getLinearVelocity() + body->getAngularVelocity();
	return std::isfinite(double(sum.length2()));
}

double sideways(const ist::Vec3& d) { return std::hypot(d.x, d.z); }

ist::Vec3 randomVector(std::mt19937_64& random, double size)
{
	std::uniform_real_distribution<double> u(-size, size);
	const double x = u(random), y = u(random);
	return {x, y, u(random)};
}

}  // namespace

double modelVolumeBelow(const ist::InnerSphereTree& tree, const ist::Pose& X_WT, double height)
{
	double volume = 0;
	for (const ist::MomentEllipsoid& ball : tree.law.slots())
	{
		if (!(ball.density > 0)) continue;
		// The share of an ellipsoid below a plane depends only on the plane's distance in half-widths.
		const ist::Vec3 up = ist::transpose(X_WT.rotation) * ist::Vec3{0, 1, 0};
		const double width = std::sqrt(dot(up, ball.shape() * up)), y = (X_WT * (tree.origin + ball.center())).y;
		const double t = std::clamp((height - y) / width, -1.0, 1.0);
		volume += ball.volume() * (1 + t) * (1 + t) * (2 - t) / 4;
	}
	return volume;
}

namespace
{
/// Volume that the model gives a solid below a height [m^3]: of its mesh where it has a surface, otherwise its leaves.
double volumeOfModel(const ExtremeSolid& solid, const ist::Pose& X, double height)
{
	return solid.tree->surface.empty() ? modelVolumeBelow(*solid.tree, X, height) : volumeBelow(solid.mesh, X, height);
}

/// Force of a cube on an equal one on which it lies flat: at the depth t below a face, that face is the nearest on (edge - 2 t)^2.
double forceOfCubes(double edge, double depth, double k)
{
	return depth > 0 ? k * depth * (edge * edge - 2 * edge * depth + 4.0 / 3 * depth * depth) : 0;
}

/// Force on A along y [N]. Pairs of trees use either the closed form of cubes, or the query of the world.
double forceUp(const ExtremeSolid& A, const ist::Pose& X_WA, const ExtremeSolid& B, const ist::Pose& X_WB, double k, bool inClosedForm)
{
	static thread_local ist::QueryWorkspace workspace;
	const ist::Pose X_AB = ist::inverse(X_WA) * X_WB;
	if (!A.tree) return -forceUp(B, X_WB, A, X_WA, k, inClosedForm);
	if (B.tree && inClosedForm)
	{
		const double edge = ist::bounds(A.mesh).longestSide(), above = X_WA.translation.y - X_WB.translation.y;
		return std::copysign(forceOfCubes(edge, edge - std::fabs(above), k), above);
	}
	const ist::BoxField box(0.5 * ist::bounds(B.mesh).size());
	const ist::OverlapResult overlap = B.tree ? ist::queryOverlap(*A.tree, *B.tree, X_AB, workspace)
											  : ist::queryField(*A.tree, box, X_AB, workspace);
	return (X_WA.rotation * ist::pressureWrench(overlap.total, {k, 0.5, 0.5}).force).y;
}
}  // namespace

double modelForceUp(const ExtremeSolid& A, const ist::Pose& X_WA, const ExtremeSolid& B, const ist::Pose& X_WB, double k)
{
	return forceUp(A, X_WA, B, X_WB, k, true);
}

double modelSinkage(const ExtremeSolid& cube, const ExtremeSolid* below, double k, double weight, double turn)
{
	const double edge = ist::bounds(cube.mesh).longestSide();
	double low = -0.05 * edge, high = 0.5 * edge;
	for (int i = 0; i < 60; ++i)
	{
		const double depth = 0.5 * (low + high);
		ist::Pose X;
		X.translation = {0, (below ? edge : edge / 2) - depth, 0};
		X.rotation = ist::rotationMatrix(ist::quaternionFromRotationVector({0, turn, 0}));
		const double force = below ? forceUp(cube, X, *below, {}, k, false) : k * volumeOfModel(cube, X, 0);
		(force < weight ? low : high) = depth;
	}
	return 0.5 * (low + high);
}

RestSetup waterCube(double edge, double seconds)
{
	RestSetup setup;
	setup.mass = 1000 * edge * edge * edge;
	setup.k = 0;
	setup.h = std::sqrt(edge) / 60;
	setup.seconds = seconds * std::sqrt(edge);
	return setup;
}

RestOutcome restOnPlane(Response response, const ExtremeSolid& cube, const RestSetup& s)
{
	const double edge = ist::bounds(cube.mesh).longestSide(), weight = s.mass * s.gravity, inertia = s.mass * edge * edge / 6;
	ExtremeWorld world(response, s.gravity);
	world.addFloor(s.place.y);
	btRigidBody* body = world.add(cube, s.mass, inertia, transformOf(s.place + ist::Vec3{0, edge / 2 + s.drop, 0}), s.k);
	RestOutcome out;
	if (response == Response::Volumetric && world.volumetric().materials().set(body, {s.k, s.dissipation})) return out;
	if (!s.mayTurn) body->setAngularFactor(btScalar(0));
	const ist::Vec3 start = positionOf(body);
	ist::Vec3 middle;
	const int steps = int(s.seconds / s.h + 0.5), watched = std::min(int(1 / s.h + 0.5), steps / 2);
	for (int i = 0; i < steps; ++i)
	{
		const double before = double(body->getLinearVelocity().y());
		const auto lost = [&] { return response == Response::Volumetric ? world.volumetric().statistics().contactsPrecisionLost : 0; };
		const uint64_t lostBefore = lost();
		world.step(s.h);
		out.precisionLost = lost() > lostBefore;
		if (!isFinite(body))
		{
			out.finite = false;
			return out;
		}
		const double risen = positionOf(body).y - start.y;
		out.highest = std::max(out.highest, risen / edge);
		if (i == steps / 2) middle = positionOf(body);
		if (i >= steps / 2) out.creep = std::max(out.creep, norm(positionOf(body) - middle) / edge);
		out.energyGain = std::max(out.energyGain, (kineticEnergy(body, s.mass, inertia) + weight * risen) / (weight * edge));
		if (i < steps - watched) continue;
		out.modelRatio += s.k * volumeOfModel(cube, toPose(body->getWorldTransform()), s.place.y) / (weight * watched);
		out.impulseRatio += (s.mass * (double(body->getLinearVelocity().y()) - before) + weight * s.h) / (weight * s.h * watched);
	}
	out.depth = edge / 2 - (positionOf(body).y - s.place.y);
	out.kinetic = kineticEnergy(body, s.mass, inertia);
	out.drift = sideways(positionOf(body) - start) / edge;
	return out;
}

CollisionOutcome collide(Response response, const ExtremeSolid& solid, const CollisionSetup& s, uint64_t seed)
{
	std::mt19937_64 random(seed);
	const double size = ist::bounds(solid.mesh).longestSide();
	ExtremeWorld world(response, 0);
	const ist::Vec3 direction = ist::normalized(randomVector(random, 1)), place = randomVector(random, s.range);
	ist::Vec3 aside, other;
	ist::completeFrame(direction, aside, other);
	const double offset = std::uniform_real_distribution<double>(0, 0.3 * size)(random);
	const ist::Vec3 common = randomVector(random, s.common);
	btRigidBody* bodies[2];
	for (int i = 0; i < 2; ++i)
	{
		const double side = i == 0 ? -0.5 : 0.5;
		const ist::Vec3 p = place + side * (s.apart * size * direction + offset * aside);
		bodies[i] = world.add(solid, s.mass, s.inertia, transformOf(p, randomVector(random, 2)), 2 * s.k);
		bodies[i]->setFriction(btScalar(std::sqrt(s.friction)));
		bodies[i]->setLinearVelocity(toBullet(common - side * s.speed * direction));
		bodies[i]->setAngularVelocity(toBullet(randomVector(random, s.spin)));
		if (s.dissipation >= 0 && response == Response::Volumetric)
			if (world.volumetric().materials().set(bodies[i], {2 * s.k, s.dissipation})) return {};
	}
	const PairMotion before(bodies, s.mass, s.inertia);
	CollisionOutcome out;
	std::optional<btEnergyAudit> audit;
	if (response == Response::Volumetric) audit.emplace(world.bullet(), world.volumetric().contacts());
	for (int i = 0; i < s.steps && norm(positionOf(bodies[0]) - positionOf(bodies[1])) < s.flown * size; ++i)
	{
		if (audit) audit->beforeStep(s.h);
		world.step(s.h);
		if (audit) audit->afterStep();
		out.finite = out.finite && isFinite(bodies[0]) && isFinite(bodies[1]);
		if (response == Response::Stock)
			out.touched |= norm(toVec3(bodies[0]->getLinearVelocity()) - common - 0.5 * s.speed * direction) > 1e-3 * s.speed;
		else if (const btISTContact* contact = world.contactBetween(bodies[0], bodies[1]))
		{
			out.touched |= contact->patchCount > 0;
			out.deepest = std::max(out.deepest, contact->total.volume / solid.tree->volume);
		}
	}
	const PairMotion after(bodies, s.mass, s.inertia);
	const double momentum = s.mass * s.speed;
	out.momentum = norm(after.linear - before.linear) / momentum;
	out.angular = norm(after.angular - before.angular) / (momentum * 0.5 * size);
	out.energy = after.kinetic / before.kinetic;
	if (!audit) return out;
	audit->beforeStep(s.h);
	world.step(s.h);
	audit->afterStep();
	out.stored = audit->total().contact / before.kinetic;
	out.physical = audit->total().physical / before.kinetic;
	out.numerical = audit->total().numerical / before.kinetic;
	return out;
}

BounceOutcome bounce(const ExtremeSolid& cube, double k, double dissipation, double stepTimesFrequency)
{
	const double edge = ist::bounds(cube.mesh).longestSide(), mass = 1, speed = 1;
	const double h = stepTimesFrequency / (edge * std::sqrt(k / mass));
	ExtremeWorld world(Response::Volumetric, 0);
	world.addFloor();
	btRigidBody* body = world.add(cube, mass, mass * edge * edge / 6, transformOf({0.2, 0.6 * edge, -0.1}), k);
	BounceOutcome out;
	if (world.volumetric().materials().set(body, {k, dissipation})) return out;
	body->setAngularFactor(btScalar(0));
	body->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
	// The time is long enough for a contact at 1 % of the speed.
	const int steps = int(20 * edge / (speed * h));
	for (int i = 0; i < steps && positionOf(body).y < 0.65 * edge; ++i)
	{
		world.step(h);
		out.deepest = std::max(out.deepest, edge / 2 - positionOf(body).y);
	}
	out.restitution = double(body->getLinearVelocity().y()) / speed;
	return out;
}

double huntCrossleyRestitution(double dv)
{
	double low = 0, high = std::min(1.0, 1 / dv);
	for (int i = 0; i < 200; ++i)
	{
		const double e = 0.5 * (low + high), left = dv * (1 + e) + std::log1p(-dv * e), right = std::log1p(dv);
		(left > right ? low : high) = e;
	}
	return 0.5 * (low + high);
}

SlopeOutcome slideOnSlope(const ExtremeSolid& slab, double friction, double angle, double heading, double k, double h)
{
	const double gravity = 9.81, height = ist::bounds(slab.mesh).size().y, depth = k > 0 ? gravity / k : 0, mass = 1;
	ExtremeWorld world(Response::Volumetric, gravity);
	world.addFloor()->setFriction(btScalar(1));
	const ist::Vec3 down{std::cos(heading), 0, std::sin(heading)};
	world.volumetric().bullet().setGravity(toBullet(gravity * (std::sin(angle) * down + ist::Vec3{0, -std::cos(angle), 0})));
	btRigidBody* body = world.add(slab, mass, mass / 12, transformOf({-3, height / 2 - depth, 2}, {0, 0.7, 0}), k);
	body->setFriction(btScalar(friction));
	const auto run = [&](double seconds) {
		for (int i = 0; i < int(seconds / h + 0.5); ++i) world.step(h);
	};
	run(3);
	SlopeOutcome out;
	const ist::Vec3 place = positionOf(body), velocity = toVec3(body->getLinearVelocity());
	run(1);
	const ist::Vec3 gained = toVec3(body->getLinearVelocity()) - velocity;
	out.acceleration = dot(gained, down);
	out.across = dot(gained, cross(down, {0, 1, 0}));
	if (std::tan(angle) < friction) run(9);
	out.creep = norm(positionOf(body) - place);
	return out;
}

double drillingStopTime(const ExtremeSolid& disc, double radius, double friction, double k, double h)
{
	const double gravity = 9.81, mass = 1, inertia = 0.5 * mass * radius * radius, spin = 20;
	const double height = ist::bounds(disc.mesh).size().z;
	const double depth = k > 0 ? mass * gravity / (k * kPi * radius * radius) : 0;
	ExtremeWorld world(Response::Volumetric, gravity);
	world.addFloor()->setFriction(btScalar(1));
	btRigidBody* body = world.add(disc, mass, inertia, transformOf({1, height / 2 - depth, -2}, {-kPi / 2, 0, 0}), k);
	body->setFriction(btScalar(friction));
	for (int i = 0; i < int(2 / h); ++i) world.step(h);
	body->setAngularVelocity(btVector3(0, btScalar(spin), 0));
	double t = 0, before = spin;
	for (; t < 60; t += h)
	{
		world.step(h);
		const double now = double(body->getAngularVelocity().y());
		if (now < 1e-3 * spin)
			return (t + h * before / std::max(before - now, 1e-12)) / (inertia * spin / (friction * mass * gravity * radius * 2 / 3));
		before = now;
	}
	return 1e300;
}
}  // namespace scenes
