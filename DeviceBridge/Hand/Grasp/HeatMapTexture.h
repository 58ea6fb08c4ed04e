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
	Impulse,      ///< impulse per area [N s/m^2]; its integral over the surface is the impulse of the contacts
	Pressure,     ///< mean pressure while touched [Pa]
	PeakPressure  ///< largest pressure [Pa]
};

struct HeatMapTextureOptions
{
	int width = 1024, height = 1024;  ///< size in texels, 1 to 16384 on each side and at most 2^26 in all, as 8192 by 8192
	int margin = 4;    ///< width of the rim around each island that copies the nearest value, so that blurring shows no seam [texels]
	double reach = 0;  ///< distance from the map's object beyond which texels stay bare [m]; 0: a hundredth of its longest side
};

/// A heat map as the texture of a mesh. The place of each texel on the object is computed once; then any map of that object can be painted.
///
/// The textured mesh may differ from the map's mesh: it is the mesh of the file, and the map's may be a repaired one. Each texel whose
/// centre a triangle covers takes the value at the nearest point of the map's object, linear between its vertices. Texels that several
/// places of the surface share (a texture that repeats, mirrored halves) take the mean, weighted by area.
class HeatMapTexture
{
public:
	/// Makes the texture offline, in 1 to 2 us and about 50 bytes per texel. `object` is the mesh() of the maps that are to be painted.
	/// Refused: a size out of range, a texture without coordinates, and one that covers no texel. Also refused: one that covers the picture
	/// more than 64 times, or more than 2^27 texels, repeats included.
	static ist::Result<HeatMapTexture> make(
		const ist::Mesh& object, const ist::TexturedMesh& surface, const HeatMapTextureOptions& options = {});

	int width() const { return m_width; }
	int height() const { return m_height; }
	/// Area of the surface on each texel [m^2], rows from the top; 0 without surface, as in the margins.
	const std::vector<double>& areas() const { return m_areas; }

	/// The whole picture. Texels without surface that are in no margin are bare. `part` selects one part; negative: all. Refused: the map
	/// of another object.
	ist::Result<Picture> colours(const HeatMap& map, HeatMapColours colours = HeatMapColours::Fingers, int part = -1) const;
	ist::Result<std::vector<double>> values(const HeatMap& map, HeatMapValue value, int part = -1) const;

private:
	struct Sample
	{
		std::uint32_t texel = 0;
		std::uint32_t triangle = 0;  // triangle of the object; kNowhere: too far from it
		float u = 0, v = 0;          // weights of the triangle's second and third corner
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
	std::vector<std::array<std::uint32_t, 3>> m_triangles;  // triangles of the object
	std::vector<double> m_vertexAreas;
	std::vector<Sample> m_samples;
	std::vector<double> m_areas;
	std::vector<Copy> m_margin;  // copies in the order in which they are made
};

/// Converts values to grey: 0 is black, `full` and above is white.
GreyPicture greyPicture(const HeatMapTexture& texture, const std::vector<double>& values, double full);
}  // namespace devicebridge
