// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/scenes/Grasp/GraspRun.h"
#include "demos/scenes/Grasp/GraspTexture.h"
#include "demos/scenes/Pages/HtmlReport.h"

namespace scenes
{
struct GraspReportOptions
{
	GraspOptions grasp;                     ///< its object and friction are not used; with a mesh, that alone is grasped
	double enough = 0.5, tooLittle = 0.04;  ///< friction of the pair with which objects are held, and with which they are not
	std::string
		maps;  ///< heat maps go to MAPS-OBJECT.ply and .csv, and where the object has a texture into it (saveTextures); empty: nowhere
};

/// Each object of graspObjectNames, or the one of the user, grasped with enough friction and with too little.
struct GraspReportOutcome
{
	struct Row
	{
		GraspOutcome rough, smooth;
		double mass = 0;
		bool own = false;                                 ///< a mesh of the user
		std::vector<devicebridge::HeatMap::Summary> map;  ///< of the rough grasp
		TextureScales scales;                             ///< of the pictures that were written; 0: none
		double mapForce = 0;                              ///< impulse on the map's vertices over that of the contacts
	};
	std::vector<Row> rows;
	double strongestAllowed = 0;  ///< that a coupling exerts [N]

	/// Held and dropped as friction says, closed, no force above what the couplings exert, and all of it on the map. Of the user's own:
	/// held.
	bool ok() const;
};
ist::Result<GraspReportOutcome> runGraspReport(const GraspReportOptions& options);

std::vector<std::vector<std::string>> summaryRows(const GraspReportOutcome& outcome);
HtmlReport makeReport(const GraspReportOutcome& outcome);
std::string makeJson(const GraspReportOutcome& outcome);
}  // namespace scenes
