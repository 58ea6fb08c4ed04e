// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

#include <cstdint>

/// The rows of the extremes, as measurements: tests judge them, the page prints them. Every scene is a function of its arguments.
/// k [Pa/m] below is that of the pair.
namespace scenes
{
/// Volume of the tree's own balls below the plane y = `height`, ball by ball in double [m^3]: the model's curve without the query.
double modelVolumeBelow(const ist::InnerSphereTree& tree, const ist::Pose& X_WT, double height);
/// The model's force on A by B along y [N]: all pairs of leaves in double. A solid without a tree is its bounding box in closed form.
double modelForceUp(const ExtremeSolid& A, const ist::Pose& X_WA, const ExtremeSolid& B, const ist::Pose& X_WB, double k);

/// Depth of a cube's face under a plane, or under the face of a cube `below`, at which the model's own curve carries `weight` [m]. One of
/// two cubes may be without a tree.
/// `turn`: of the cube against the one below, about the vertical [rad].
double modelSinkage(const ExtremeSolid& cube, const ExtremeSolid* below, double k, double weight, double turn = 0);

struct RestSetup
{
	double mass = 1, k = 1e4;
	double h = 1.0 / 60, seconds = 4;
	double drop = 0;  ///< of the lowest face above the plane [m]
	ist::Vec3 place;  ///< of the plane's point under the body
	double gravity = 9.81;
	double dissipation = -1;  ///< negative: default [s/m]
	bool mayTurn = true;
};
struct RestOutcome
{
	bool finite = true;
	double highest = 0;          ///< of the face above where it started, over the edge
	double energyGain = 0;       ///< highest mechanical energy without contact, over its start, over m g edge
	double depth = 0;            ///< of the lower face's centre under the plane at the end [m]
	double impulseRatio = 0;     ///< impulses of the last second (half of the run, if shorter) over weight times time
	double modelRatio = 0;       ///< the model's force in the end pose over the weight
	double kinetic = 0;          ///< at the end [J]
	double drift = 0;            ///< sideways, over the edge
	bool precisionLost = false;  ///< reported by the solver at the end (contactsPrecisionLost)
	double creep = 0;            ///< farthest that it was in the second half from where it was in the middle, over the edge
};
/// A cube falls on a plane, or is put on it, and rests. `edge` of the cube is that of the mesh.
RestOutcome restOnPlane(Response response, const ExtremeSolid& cube, const RestSetup& setup);

struct CollisionSetup
{
	double mass = 2, inertia = 0.2;
	double k = 1e5;           ///< of the pair [Pa/m]; 0: default rule
	double dissipation = -1;  ///< negative: default
	double common = 1;        ///< velocity that both have on top, per axis at most [m/s]
	double speed = 4, spin = 4, h = 1.0 / 60, friction = 0;
	double apart = 1.8;  ///< of the centres at the start, over the longest side
	int steps = 1000;
	double range = 10;  ///< the pair starts within this distance of the origin, per axis [m]
	double flown = 10;  ///< ends when the pair is that many sizes apart
};
struct CollisionOutcome
{
	bool touched = false, finite = true;
	double momentum = 0, angular = 0;    ///< error over m v, over m v R
	double energy = 0;                   ///< kinetic energy at the end over that at the start
	double deepest = 0;                  ///< most overlap, over the smaller volume
	double physical = 0, numerical = 0;  ///< lost (btEnergyAudit), over the kinetic energy at the start; only with Response::Volumetric
};
/// Two equal bodies, from random poses and velocities, meet in free flight. Angular momentum about the joint centre of mass.
CollisionOutcome collide(Response response, const ExtremeSolid& solid, const CollisionSetup& setup, uint64_t seed);

struct BounceOutcome
{
	double restitution = 0;  ///< speed away over speed towards
	double deepest = 0;      ///< [m]
};
/// A cube of 1 kg, face down and kept from turning, meets a plane at 1 m/s without gravity; contact of frequency sqrt(k A / m).
BounceOutcome bounce(const ExtremeSolid& cube, double k, double dissipation, double stepTimesFrequency);
/// Hunt and Crossley's closed form, for any law of force over depth: e of d (v_i + v_o) = ln((1 + d v_i) / (1 - d v_o)).
double huntCrossleyRestitution(double dissipationTimesSpeed);

struct SlopeOutcome
{
	double creep = 0;         ///< in the last 10 s [m]
	double acceleration = 0;  ///< in the last second, down the slope [m/s^2]
	double across = 0;        ///< the same, across [m/s^2]
};
/// A slab of 1 m by 1 m on a plane, gravity tilted by `angle` [rad] towards the horizontal `heading` [rad]; k of the pair [Pa/m].
SlopeOutcome slideOnSlope(const ExtremeSolid& slab, double friction, double angle, double heading, double k, double h);

/// A disc (axis z of its mesh upright) of this radius spins on a plane until it stops: time over I w / (mu m g 2/3 a).
double drillingStopTime(const ExtremeSolid& disc, double radius, double friction, double k, double h);
}  // namespace scenes
