// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"
#include "DeviceBridge/Hand/Grasp/HeatMapFile.h"
#include "DeviceBridge/Hand/Grasp/Picture.h"

#include <optional>

namespace devicebridge
{
enum class HeatMapValue
{
	Contact,      ///< share of the grasps
	Dwell,        ///< [s]
	Impulse,      ///< on a unit of area [N s/m^2]: summed over the surface, what the contacts gave
	Pressure,     ///< mean while touched [Pa]
	PeakPressure  ///< [Pa]
};

struct HeatMapTextureOptions
{
	int width = 1024, height = 1024;  ///< texels, 1 to 16384 on each side and 2^26 in all, as 8192 by 8192
	int margin = 4;  ///< texels around each island of the picture that take the nearest one's value, so that no seam shows when the picture
					 ///< is blurred
	double reach =
		0;  ///< texels whose place on the surface is further from the map's object stay bare [m]; 0: a hundredth of its longest side
};

/// A heat map as the texture of a mesh: where each texel lies on the object is found once, then any map of that object is painted.
///
/// The textured mesh need not be the map's own: it is the file's, and the map's may be repaired. Each texel whose centre a triangle covers
/// takes the value at the nearest point of the map's object, linear between its vertices. Texels that several places of the surface share
/// (a texture that repeats, mirrored halves) take their mean, weighted by area.
class HeatMapTexture
{
public:
	/// Offline, 1 to 2 us and some 50 bytes a texel. `object`: mesh() of the maps that are to be painted. Refused: a size out of range, a
	/// texture without places, one that covers no texel, covers the picture more than 64 times, or covers more than 2^27 texels, each
	/// counted as often as it repeats.
	static ist::Result<HeatMapTexture> make(
		const ist::Mesh& object, const ist::TexturedMesh& surface, const HeatMapTextureOptions& options = {});

	int width() const { return m_width; }
	int height() const { return m_height; }
	/// Of the surface, for each texel, rows from the top; 0 where there is none, as in the margins [m^2].
	const std::vector<double>& areas() const { return m_areas; }

	/// The whole picture; what no surface lies on, and is in no margin, is bare. `part`: one alone; negative: all. Refused: the map of
	/// another object.
	ist::Result<Picture> colours(const HeatMap& map, HeatMapColours colours = HeatMapColours::Fingers, int part = -1) const;
	ist::Result<std::vector<double>> values(const HeatMap& map, HeatMapValue value, int part = -1) const;

private:
	struct Sample
	{
		std::uint32_t texel = 0;
		std::uint32_t triangle = 0;  // of the object; kNowhere: too far from it
		float u = 0, v = 0;          // weights of its second and third corner
		double area = 0;
	};
	struct Copy
	{
		std::uint32_t to = 0, from = 0;
	};
	class Object;
	HeatMapTexture() = default;
	void cover(const ist::TexturedMesh& surface, const Object& object);
	void grow(int margin);
	std::optional<ist::Error> checkObject(const HeatMap& map) const;
	template <class At> std::vector<double> blended(double bare, const At& atVertex) const;

	int m_width = 0, m_height = 0;
	uint64_t m_object = 0;                                  // ist::meshHash
	std::vector<std::array<std::uint32_t, 3>> m_triangles;  // of the object
	std::vector<double> m_vertexAreas;
	std::vector<Sample> m_samples;
	std::vector<double> m_areas;
	std::vector<Copy> m_margin;  // in the order in which they are copied
};

/// Black is 0 and white `full`, what is beyond is white.
GreyPicture greyPicture(const HeatMapTexture& texture, const std::vector<double>& values, double full);
}  // namespace devicebridge
