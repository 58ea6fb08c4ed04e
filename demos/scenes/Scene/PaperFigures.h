// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"
#include "demos/scenes/Scene/SceneRun.h"

#include <string>
#include <vector>

namespace scenes
{
/// The figures in which Weller and others show their rates (UnrealHaptics, figures 7 to 9): rate of the force thread and of the contact
/// thread over time, beside the number of intersecting pairs; and what our threads cost over the query alone.
struct PaperScene
{
	SceneOutcome run;
	/// Time of the query alone, asked again after the run at the pose of each tick that brought a new answer [us of processor]; negative:
	/// none.
	std::vector<double> bareQuery;

	struct Spread
	{
		double mean = 0, p50 = 0, p999 = 0, max = 0;
	};
	Spread period;                          ///< of the force thread [s]
	Spread tick;                            ///< processor time of the force thread per tick [us]
	Spread answer;                          ///< processor time of the contact thread per answer, waiting for the question included [us]
	Spread device;                          ///< of the tick, what the simulated hand took, which stands for a device and its driver [us]
	Spread asked;                           ///< of the answer, what the queries took [us]
	Spread query;                           ///< bareQuery [us]
	Spread touchingPairs;                   ///< of the ticks that touch
	double forceRate = 0, contactRate = 0;  ///< mean [Hz]
	double slowestForceRate = 0, slowestContactRate = 0;  ///< of all stretches of 0.1 s [Hz]
	/// Share of a tick of 1 ms that both threads need beyond the query and the simulated hand, in the mean: wakings, law, model of the
	/// contact, the tool's motion, safety. Against the query as it was asked in the run, side by side; and against the same asked again in
	/// one go, whose data is then warm.
	double overhead = 0, overheadWarm = 0;
	/// Of it, what the system takes to wake both threads once a tick: that of two that do nothing else, measured after the run.
	double waking = 0;
};

/// Runs each scene file in real time; its topology is to be `contact-thread`, and what its tool touches is to be fixed.
ist::Result<std::vector<PaperScene>> runPaperFigures(const std::vector<std::string>& files, const SceneRunOptions& options);

HtmlReport paperPage(const std::vector<PaperScene>& scenes);
std::vector<std::vector<std::string>> paperRows(const std::vector<PaperScene>& scenes);
std::string paperJson(const std::vector<PaperScene>& scenes);
/// One row a tick.
std::string paperCsv(const PaperScene& scene);
}  // namespace scenes
