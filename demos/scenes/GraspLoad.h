// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/GraspRun.h"
#include "demos/scenes/HtmlReport.h"

namespace scenes
{
struct GraspLoadOptions
{
	GraspOptions grasp;      ///< its spheres and step are those of the load, unless `light`
	bool light = false;      ///< the spheres and step of `grasp`
};

/// One tick with contact: contact, response and heat map, in processor time of the one thread.
struct GraspLoadTick
{
	double time = 0;         ///< [s]
	double microseconds = 0; ///< of it all
	double mapMicroseconds = 0;
	double pairs = 0;        ///< with the object
	int parts = 0;           ///< in contact with the object
};

struct GraspLoad
{
	std::string name;
	std::vector<GraspLoadTick> ticks;  ///< those with contact only
	size_t handSpheres = 0, objectSpheres = 0;
	double step = 0;
	bool held = false;

	double quantileMicroseconds(double p) const;
	double mostPairs() const;
	int mostParts() const;
};

struct GraspLoadOutcome
{
	std::vector<GraspLoad> loads;  ///< the firm skin first

	/// Both touched, and the firm hand held the object.
	bool ok() const;
};

/// The load of Weller et al.'s grasping: 16 parts of 5,000 spheres and an object of 10,000, contact, response and heat map in each tick of a
/// millisecond; the map looks at one part a tick. Once with the hand as it is, and once with a skin so soft that fingers sink in about as far as those
/// of a hand that nothing holds back. Offline: a minute for the trees that the cache lacks.
ist::Result<GraspLoadOutcome> runGraspLoad(const GraspLoadOptions& options);

std::vector<std::vector<std::string>> summaryRows(const GraspLoadOutcome& outcome);
HtmlReport makeReport(const GraspLoadOutcome& outcome);
std::string makeJson(const GraspLoadOutcome& outcome);
}  // namespace scenes
