// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Hand/Grasp/HeatMap.h"

#include <optional>
#include <string>
#include <vector>

namespace devicebridge
{
enum class HeatMapColours
{
	Fingers,     ///< one colour per finger and grey for the palm, stronger the more grasps touched the place; the bare surface is light
	ContactPose  ///< red = green = blue = contact, 1 to 255; 0 means "not observed", which never occurs in simulation (Brahmbhatt et al.,
				 ///< ContactPose, 2020)
};

/// Colour of a hand's part, 0 to 255, by its GRAB id: index, middle, little, ring finger, thumb, palm. The colours suit colour-blind
/// readers (Okabe and Ito).
struct HeatMapColour
{
	std::uint8_t r = 0, g = 0, b = 0;
};
HeatMapColour handPartColour(int grabId);
/// Colour of the values `found` that `map` has at a place.
HeatMapColour heatMapColour(const HeatMap& map, const HeatMap::Vertex& found, HeatMapColours colours);

/// Writes binary little-endian PLY. Each vertex has `x y z` (float, m, the mesh's own frame), `red green blue` (uchar), `contact dwell
/// impulse pressure peak_pressure` (float; share, s, N s, Pa, Pa), `part` (int, its id; 0 for none). The triangles follow. `part` selects
/// one part; -1: all. Writes the whole file or none.
std::optional<ist::Error> saveHeatMap(
	const HeatMap& map, const std::string& path, HeatMapColours colours = HeatMapColours::Fingers, int part = -1);

/// Writes a map in the order of the mesh file that its mesh was made of. The file's vertices come first, in its order, each with the
/// values of the map's vertex at its place; a vertex of which repair left nothing is untouched. The map's other vertices follow, which
/// repair and division added. If there are such, a last property `file_vertex` (int) has the index of each vertex in the file, and -1 for
/// those. `file`: importVertices(), moved and scaled as the map's mesh was. Further error: none of them is a vertex of the map.
std::optional<ist::Error> saveHeatMapOfFile(const HeatMap& map, const std::vector<ist::Vec3>& file, const std::string& path,
	HeatMapColours colours = HeatMapColours::Fingers, int part = -1);

/// A table with a header and a row for each part that touched, comma separated:
/// part,id,area_m2,dwell_s,mean_force_N,peak_force_N,impulse_Ns,grasps,largest_depth_m,peak_pressure_Pa
std::string heatMapTable(const HeatMap& map);
std::optional<ist::Error> saveHeatMapTable(const HeatMap& map, const std::string& path);
}  // namespace devicebridge
