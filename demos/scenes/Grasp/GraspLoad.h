// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Grasp/GraspRun.h"
#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
struct GraspLoadOptions
{
	GraspOptions grasp;  ///< its numbers of spheres and its step are replaced by those of the load, unless `light`
	bool light = false;  ///< true: the numbers of spheres and the step of `grasp` are used
};

/// One tick with contact. Times are processor times of contact, response and heat map.
struct GraspLoadTick
{
	double time = 0;               ///< [s]
	double oneMicroseconds = 0;    ///< time of the whole tick in one thread
	double twoMicroseconds = 0;    ///< time of the busier of two threads that share the queries, plus everything else
	double queryMicroseconds = 0;  ///< sum of the queries that threads can share
	/// time of the heat map; time of the response and of everything that is not a shared query, in one thread
	double mapMicroseconds = 0, restMicroseconds = 0;
	double pairs = 0;  ///< pairs of leaves of the hand and the object
	int parts = 0;     ///< number of parts in contact with the object
};

/// Force error of a part's contact with the object, against the force of the leaves. It is a share of the larger of the latter and the
/// force floor (btISTCachedResult::floorForce).
struct GraspLoadError
{
	double promised = 0, found = 0;
};

struct GraspLoad
{
	std::string name;
	double accepted = 0;                 ///< force error that the world accepts; 0: the leaves answer
	bool remembers = false;              ///< true: pairs have Verlet lists (btISTWorld::setVerletLists)
	std::vector<GraspLoadTick> ticks;    ///< ticks with contact only
	std::vector<GraspLoadError> errors;  ///< errors of all contacts in some ticks, for ways in which not every query traverses the leaves
	size_t handSpheres = 0, objectSpheres = 0;
	double step = 0;
	double mapSeconds = 0;  ///< longest time between two updates of one place by the heat map [s]
	bool held = false;

	double quantileMicroseconds(double p, double GraspLoadTick::*of = &GraspLoadTick::twoMicroseconds) const;
	double quantileError(double p, double GraspLoadError::*of) const;
	double mostPairs() const;
	int mostParts() const;
};

struct GraspLoadOutcome
{
	std::vector<GraspLoad> loads;  ///< loads, the firm skin first; for each skin, the leaves first

	/// True when all hands touched, and the firm one held the object.
	bool ok() const;
};

/// The load of the grasp by Weller et al.: 16 parts of 5,000 spheres and an object of 10,000. Contact, response and heat map run in each
/// tick of 1 ms; the map does its share in each tick (BulletHeatMapRounds).
///
/// The grasp runs with the hand as it is, and with soft skins. With those the fingers sink in about as far as the fingers of a hand that
/// nothing stops. Each skin runs with the leaves, with Verlet lists, and with accepted force errors, with and without Verlet lists.
///
/// Queries have two threads. The time on two free cores is the owner's own time plus that of the busier thread. The queries are assigned in
/// the order in which threads claim them. This time does not depend on the machine's other load, and ignores that two cores share memory.
/// Offline: one minute for the trees that the cache lacks.
ist::Result<GraspLoadOutcome> runGraspLoad(const GraspLoadOptions& options);

std::vector<std::vector<std::string>> summaryRows(const GraspLoadOutcome& outcome);
HtmlReport makeReport(const GraspLoadOutcome& outcome);
std::string makeJson(const GraspLoadOutcome& outcome);
}  // namespace scenes
