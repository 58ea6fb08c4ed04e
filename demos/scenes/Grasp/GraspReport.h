// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Grasp/GraspRun.h"
#include "demos/scenes/Grasp/GraspTexture.h"
#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
struct GraspReportOptions
{
	GraspOptions grasp;  ///< object and friction are not used; with a mesh, only that mesh is grasped
	/// friction coefficient of the pair with which objects are held, and one with which they are not
	double enough = 0.5, tooLittle = 0.04;
	/// heat maps are written to MAPS-OBJECT.ply and .csv, and into the object's texture if it has one (saveTextures); empty: no files
	std::string maps;
};

/// Each object of graspObjectNames, or the user's mesh, grasped with enough friction and with too little.
struct GraspReportOutcome
{
	struct Row
	{
		GraspOutcome rough, smooth;
		double mass = 0;
		bool own = false;                                 ///< true: a mesh of the user
		std::vector<devicebridge::HeatMap::Summary> map;  ///< summary of the rough grasp
		TextureScales scales;                             ///< scales of the written pictures; 0: none was written
		double mapForce = 0;                              ///< impulse on the map's vertices, divided by that of the contacts
	};
	std::vector<Row> rows;
	double strongestAllowed = 0;  ///< largest force that the coupling of a bone may exert [N]
	double palmAllowed = 0;       ///< largest force that the coupling of the palm may exert [N]

	/// What is wrong, a sentence each with the limit and the excess; empty if all is well. Objects must be held and dropped as friction
	/// demands, and grasps have force closure. No force may exceed what the coupling of its part exerts, and the map must contain all of
	/// it. The user's own mesh must only be held.
	std::vector<std::string> failures() const;
	bool ok() const { return !rows.empty() && failures().empty(); }
};
ist::Result<GraspReportOutcome> runGraspReport(const GraspReportOptions& options);

std::vector<std::vector<std::string>> summaryRows(const GraspReportOutcome& outcome);
HtmlReport makeReport(const GraspReportOutcome& outcome);
std::string makeJson(const GraspReportOutcome& outcome);
}  // namespace scenes
