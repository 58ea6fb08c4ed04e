// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Grasp/GraspRun.h"
#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
struct GraspLoadOptions
{
	GraspOptions grasp;  ///< its spheres and step are those of the load, unless `light`
	bool light = false;  ///< the spheres and step of `grasp`
};

/// One tick with contact: contact, response and heat map, in processor time.
struct GraspLoadTick
{
	double time = 0;                                   ///< [s]
	double oneMicroseconds = 0;                        ///< of it all, by one thread
	double twoMicroseconds = 0;                        ///< of the busier of two threads that share the queries, and all the rest
	double queryMicroseconds = 0;                      ///< of the queries that can be shared, together
	double mapMicroseconds = 0, restMicroseconds = 0;  ///< of the heat map; of the response and all that is no shared query, by one thread
	double pairs = 0;                                  ///< with the object
	int parts = 0;                                     ///< in contact with the object
};

/// How far the force of a part's contact with the object was from the leaves', as a share of the larger of that and the floor
/// (btISTCachedResult::floorForce).
struct GraspLoadError
{
	double promised = 0, found = 0;
};

struct GraspLoad
{
	std::string name;
	double accepted = 0;                 ///< force error that the world accepts; 0: the leaves answer
	bool remembers = false;              ///< pairs remember which leaves were near (btISTWorld::setVerletLists)
	std::vector<GraspLoadTick> ticks;    ///< those with contact only
	std::vector<GraspLoadError> errors;  ///< where not every query searches among the leaves: of all contacts of some ticks
	size_t handSpheres = 0, objectSpheres = 0;
	double step = 0;
	double mapSeconds = 0;  ///< most time from one moment that the heat map looks at to the next [s]
	bool held = false;

	double quantileMicroseconds(double p, double GraspLoadTick::*of = &GraspLoadTick::twoMicroseconds) const;
	double quantileError(double p, double GraspLoadError::*of) const;
	double mostPairs() const;
	int mostParts() const;
};

struct GraspLoadOutcome
{
	std::vector<GraspLoad> loads;  ///< the firm skin first, each skin with the leaves first

	/// All touched, and the firm hand held the object.
	bool ok() const;
};

/// The load of Weller et al.'s grasping: 16 parts of 5,000 spheres and an object of 10,000, contact, response and heat map in each tick of
/// a millisecond; the map takes its share of each (BulletHeatMapRounds). Once with the hand as it is, and with skins so soft that fingers
/// sink in about as far as those of a hand that nothing holds back; each with the leaves, with leaves that pairs remember, and with
/// accepted force errors, remembered and not. Queries have two threads. What two free cores would take is the owner's own time and that of
/// the busier thread, the queries dealt in the order in which they are claimed: it does not depend on what else the machine does, and
/// leaves out that two cores share memory. Offline: a minute for the trees that the cache lacks.
ist::Result<GraspLoadOutcome> runGraspLoad(const GraspLoadOptions& options);

std::vector<std::vector<std::string>> summaryRows(const GraspLoadOutcome& outcome);
HtmlReport makeReport(const GraspLoadOutcome& outcome);
std::string makeJson(const GraspLoadOutcome& outcome);
}  // namespace scenes
