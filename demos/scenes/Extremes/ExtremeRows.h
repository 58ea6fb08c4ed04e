// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Extremes/ExtremeWorld.h"

#include <cstdint>

/// The rows of the page on extremes, as measurements: tests judge them, and the page prints them. Every scene is a function of its
/// arguments. k [Pa/m] is always that of the pair; with 0 it is not set, and the default rule decides.
namespace scenes
{
/// Volume of the tree's own balls below the plane y = `height`, ball by ball in double [m^3]. This is the model's curve without the
/// query.
double modelVolumeBelow(const ist::InnerSphereTree& tree, const ist::Pose& X_WT, double height);
/// The model's force on A by B along y [N], of two equal cubes that lie flat on each other, in closed form. Of a solid without a tree, that
/// of the other's leaves in its bounding box.
double modelForceUp(const ExtremeSolid& A, const ist::Pose& X_WA, const ExtremeSolid& B, const ist::Pose& X_WB, double k);

/// Depth at which the model's own curve carries `weight` [m]: that of a cube's face under a plane, or under the face of the cube `below`.
/// One of the two cubes may be without a tree. `turn` is the rotation of the cube against the one below, about the vertical [rad].
double modelSinkage(const ExtremeSolid& cube, const ExtremeSolid* below, double k, double weight, double turn = 0);

struct RestSetup
{
	double mass = 1, k = 1e4;
	double h = 1.0 / 60, seconds = 4;
	double drop = 0;  ///< height of the lowest face above the plane at the start [m]
	ist::Vec3 place;  ///< point of the plane under the body
	double gravity = 9.81;
	double dissipation = -1;  ///< dissipation [s/m]; negative: default
	bool mayTurn = true;
};
/// A cube of water under Froude's scaling: times are proportional to the root of the edge, and so is the step. `seconds`: for an edge of
/// 1 m. The stiffness is not set.
RestSetup waterCube(double edge, double seconds);
struct RestOutcome
{
	bool finite = true;
	double highest = 0;          ///< largest height of the face above its start, divided by the edge
	double energyGain = 0;       ///< largest mechanical energy without contact minus that at the start, divided by m g edge
	double depth = 0;            ///< depth of the lower face's centre under the plane at the end [m]
	double impulseRatio = 0;     ///< impulses of the last second (or of the second half of a shorter run), divided by weight times time
	double modelRatio = 0;       ///< the model's force in the end pose, divided by the weight
	double kinetic = 0;          ///< kinetic energy at the end [J]
	double drift = 0;            ///< sideways motion, divided by the edge
	bool precisionLost = false;  ///< true: the solver reported it at the end (contactsPrecisionLost)
	double creep = 0;            ///< largest distance in the second half of the run from the position in its middle, divided by the edge
};
/// A cube falls on a plane, or is put on it, and rests. The edge of the cube is that of its mesh.
RestOutcome restOnPlane(Response response, const ExtremeSolid& cube, const RestSetup& setup);

struct CollisionSetup
{
	double mass = 2, inertia = 0.2;
	double k = 1e5;           ///< stiffness of the pair [Pa/m]
	double dissipation = -1;  ///< dissipation [s/m]; negative: default
	double common = 1;        ///< largest velocity per axis that is added to both bodies [m/s]
	double speed = 4, spin = 4, h = 1.0 / 60, friction = 0;
	double apart = 1.8;  ///< distance of the centres at the start, divided by the longest side
	int steps = 1000;
	double range = 10;  ///< largest distance of the pair from the origin at the start, per axis [m]
	double flown = 10;  ///< the run ends when the bodies are that many sizes apart
};
struct CollisionOutcome
{
	bool touched = false, finite = true;
	double momentum = 0, angular = 0;  ///< error of the momentum over m v, and of the angular momentum over m v R
	double energy = 0;                 ///< kinetic energy at the end, divided by that at the start
	double deepest = 0;                ///< largest overlap, divided by the smaller volume
	/// energy losses, and what the contact still stores (btEnergyAudit), divided by the kinetic energy at the start; only with
	/// Response::Volumetric
	double physical = 0, numerical = 0, stored = 0;
};
/// Two equal bodies with random poses and velocities collide in free flight. The angular momentum is taken about the joint centre of
/// mass.
CollisionOutcome collide(Response response, const ExtremeSolid& solid, const CollisionSetup& setup, uint64_t seed);

struct BounceOutcome
{
	double restitution = 0;  ///< speed after the bounce, divided by the speed before
	double deepest = 0;      ///< largest depth [m]
};
/// A cube of 1 kg meets a plane at 1 m/s without gravity, face down and prevented from rotating. The frequency of the contact is sqrt(k A
/// / m).
BounceOutcome bounce(const ExtremeSolid& cube, double k, double dissipation, double stepTimesFrequency);
/// Restitution e by Hunt and Crossley's closed form, for any law of force over depth: d (v_i + v_o) = ln((1 + d v_i) / (1 - d v_o)).
double huntCrossleyRestitution(double dissipationTimesSpeed);

struct SlopeOutcome
{
	double creep = 0;         ///< creep in the last 10 s [m]
	double acceleration = 0;  ///< acceleration down the slope in the last second [m/s^2]
	double across = 0;        ///< acceleration across the slope in the last second [m/s^2]
};
/// A slab of 1 m by 1 m lies on a plane. Gravity is tilted by `angle` [rad] towards the horizontal `heading` [rad]. k is that of the pair
/// [Pa/m].
SlopeOutcome slideOnSlope(const ExtremeSolid& slab, double friction, double angle, double heading, double k, double h);

/// A disc of this radius (axis z of its mesh upright) spins on a plane until it stops. Returns its time divided by I w / (mu m g 2/3 a).
double drillingStopTime(const ExtremeSolid& disc, double radius, double friction, double k, double h);
}  // namespace scenes
