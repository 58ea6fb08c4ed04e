// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/GraspTexture.h"

#include "demos/scenes/Pages/TextFile.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <tuple>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
template <class... Values> void print(std::string& text, const char* format, Values... values)
{
	char line[160];
	std::snprintf(line, sizeof line, format, values...);
	text += line;
}

/// Text of a Wavefront OBJ file; each corner has its own texture coordinates.
std::string objText(const TexturedMesh& surface, const std::string& material)
{
	std::string text = "mtllib " + material + ".mtl\nusemtl touched\n";
	for (const Vec3& p : surface.mesh.vertices) print(text, "v %.7g %.7g %.7g\n", p.x, p.y, p.z);
	for (const auto& t : surface.places)
		for (const TexturePlace& place : t) print(text, "vt %.6f %.6f\n", place.u, place.v);
	for (size_t t = 0; t < surface.places.size(); ++t)
	{
		const auto& c = surface.mesh.triangles[t];
		print(text, "f %u/%zu %u/%zu %u/%zu\n", c[0] + 1, 3 * t + 1, c[1] + 1, 3 * t + 2, c[2] + 1, 3 * t + 3);
	}
	return text;
}
}  // namespace

Result<TextureScales> saveTextures(const HeatMap& map, const TexturedMesh& surface, const std::string& path)
{
	const Result<HeatMapTexture> made = HeatMapTexture::make(map.mesh(), surface);
	if (!made) return made.error();
	const HeatMapTexture& texture = made.value();
	const Result<Picture> colours = texture.colours(map);
	if (!colours) return colours.error();
	if (auto error = savePicture(colours.value(), path + ".png")) return *error;
	TextureScales scales;
	for (const auto& [value, name, scale] : {std::tuple{HeatMapValue::Impulse, "-impulse.png", &scales.impulse},
			 std::tuple{HeatMapValue::Pressure, "-pressure.png", &scales.pressure}})
	{
		const Result<std::vector<double>> values = texture.values(map, value);
		if (!values) return values.error();
		*scale = *std::max_element(values.value().begin(), values.value().end());
		if (auto error = savePicture(greyPicture(texture, values.value(), *scale), path + name)) return *error;
	}
	const std::string name = std::filesystem::path(path).filename().string();
	if (!writeTextFile(path + ".obj", objText(surface, name)) ||
		!writeTextFile(path + ".mtl", "newmtl touched\nKd 1 1 1\nmap_Kd " + name + ".png\n"))
		return Error{"cannot write " + path + ".obj"};
	return scales;
}
}  // namespace scenes
