// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Pages/HtmlReport.h"
#include "demos/scenes/Scene/SceneRun.h"

#include <string>
#include <vector>

namespace scenes
{
/// Figures like those in which Weller et al. show their rates (UnrealHaptics, figures 7 to 9). They show the rates of the force thread
/// and of the contact thread over time, beside the number of intersecting pairs. They also show the cost of our threads beyond the query
/// alone.
struct PaperScene
{
	SceneOutcome run;
	const SceneHandRun& hand() const { return run.hands.front(); }
	/// Time of the query alone, repeated after the run at the pose of each tick that brought a new answer [us of processor time].
	/// Negative: no new answer.
	std::vector<double> bareQuery;

	struct Spread
	{
		double mean = 0, p50 = 0, p999 = 0, max = 0;
	};
	Spread period;                          ///< period of the force thread [s]
	Spread tick;                            ///< processor time of the force thread per tick [us]
	Spread answer;                          ///< processor time of the contact thread per answer, including the wait for the question [us]
	Spread device;                          ///< part of the tick in the simulated hand, which stands for a device and its driver [us]
	Spread asked;                           ///< part of the answer in the queries [us]
	Spread query;                           ///< bareQuery [us]
	Spread touchingPairs;                   ///< pairs of leaves in the ticks that touch
	double forceRate = 0, contactRate = 0;  ///< mean rates [Hz]
	double slowestForceRate = 0, slowestContactRate = 0;  ///< lowest rates over all intervals of 0.1 s [Hz]
	/// Mean share of a tick of 1 ms that both threads need beyond the query and the simulated hand: wake-ups, force law, contact model,
	/// motion of the tool, safety. `overhead` subtracts the query as it ran during the run. `overheadWarm` subtracts the same queries
	/// repeated in sequence, with warm caches.
	double overhead = 0, overheadWarm = 0;
	/// Part of it that the system needs to wake both threads once a tick. It is measured after the run, with two threads that do nothing
	/// else.
	double waking = 0;
};

/// Runs each scene file in real time. Its topology must be `contact-thread`, and the bodies that its tool touches must be fixed.
ist::Result<std::vector<PaperScene>> runPaperFigures(const std::vector<std::string>& files, const SceneRunOptions& options);

HtmlReport paperPage(const std::vector<PaperScene>& scenes);
std::vector<std::vector<std::string>> paperRows(const std::vector<PaperScene>& scenes);
std::string paperJson(const std::vector<PaperScene>& scenes);
/// CSV table with one row a tick.
std::string paperCsv(const PaperScene& scene);
}  // namespace scenes
