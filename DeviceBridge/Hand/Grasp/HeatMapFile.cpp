// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/HeatMapFile.h"

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "DeviceBridge/Hand/HandParts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <locale>
#include <sstream>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr HeatMapColour kBare{226, 226, 222}, kPalmColour{110, 110, 110};
constexpr HeatMapColour kFingerColours[kHandFingers] = {{0, 114, 178}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {213, 94, 0}};

std::uint8_t mixed(std::uint8_t a, std::uint8_t b, double u) { return std::uint8_t(std::lround(a + u * (double(b) - a))); }

/// Little-endian words on any machine.
class Bytes
{
public:
	void add(std::uint32_t word)
	{
		for (int shift = 0; shift < 32; shift += 8) m_bytes.push_back(std::byte(word >> shift & 0xff));
	}
	void add(float value)
	{
		std::uint32_t word;
		std::memcpy(&word, &value, sizeof word);
		add(word);
	}
	void add(std::uint8_t byte) { m_bytes.push_back(std::byte(byte)); }
	void add(const std::string& text)
	{
		for (const char c : text) m_bytes.push_back(std::byte(c));
	}
	const std::vector<std::byte>& all() const { return m_bytes; }

private:
	std::vector<std::byte> m_bytes;
};

/// The next float if the first byte is a line break. Some readers (assimp 5.2) take such a byte for a part of the header and then misread
/// the rest.
float notALineBreak(float value)
{
	std::uint32_t word;
	std::memcpy(&word, &value, sizeof word);
	if ((word & 0xff) == '\n' || (word & 0xff) == '\r') ++word;
	std::memcpy(&value, &word, sizeof word);
	return value;
}

std::optional<Error> save(const std::string& path, const std::byte* bytes, size_t size)
{
	const Result<size_t> written = writeFileAtomically(path, bytes, size);
	if (!written) return written.error();
	return std::nullopt;
}
}  // namespace

HeatMapColour handPartColour(int id)
{
	for (const bool left : {false, true})
		for (int part = 1; part < kHandParts; ++part)
			if (handPartId(part, left) == id) return kFingerColours[fingerOf(part)];
	return kPalmColour;
}

HeatMapColour heatMapColour(const HeatMap& map, const HeatMap::Vertex& v, HeatMapColours colours)
{
	if (colours == HeatMapColours::ContactPose)
	{
		const auto level = std::uint8_t(std::lround(1 + 254 * std::clamp(v.contact, 0.0, 1.0)));
		return {level, level, level};
	}
	if (v.part < 0) return kBare;
	const HeatMapColour full = handPartColour(map.partId(v.part));
	const double u = 0.35 + 0.65 * std::clamp(v.contact, 0.0, 1.0);
	return {mixed(kBare.r, full.r, u), mixed(kBare.g, full.g, u), mixed(kBare.b, full.b, u)};
}

std::optional<Error> saveHeatMap(const HeatMap& map, const std::string& path, HeatMapColours colours, int part)
{
	if (part >= map.parts()) return Error{"the heat map has no part " + std::to_string(part) + ", only " + std::to_string(map.parts())};
	const std::vector<HeatMap::Vertex> values = map.vertices(part);
	const Mesh& mesh = map.mesh();
	Bytes file;
	file.add("ply\nformat binary_little_endian 1.0\ncomment lengths in metres; part is the label of GRAB, 0 for none\ncomment grasps " +
		std::to_string(map.grasps()) + "\n");
	file.add("element vertex " + std::to_string(values.size()) + "\nproperty float x\nproperty float y\nproperty float z\n");
	file.add("property uchar red\nproperty uchar green\nproperty uchar blue\n");
	file.add("property float contact\nproperty float dwell\nproperty float impulse\nproperty float pressure\nproperty float "
			 "peak_pressure\nproperty int part\n");
	file.add("element face " + std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n");
	for (size_t i = 0; i < values.size(); ++i)
	{
		const HeatMap::Vertex& v = values[i];
		const Vec3& p = mesh.vertices[i];
		file.add(i == 0 ? notALineBreak(float(p.x)) : float(p.x));
		file.add(float(p.y)), file.add(float(p.z));
		const HeatMapColour colour = heatMapColour(map, v, colours);
		file.add(colour.r), file.add(colour.g), file.add(colour.b);
		for (const double x : {v.contact, v.dwell, v.impulse, v.pressure, v.peak}) file.add(float(x));
		file.add(std::uint32_t(v.part < 0 ? 0 : map.partId(v.part)));
	}
	for (const auto& t : mesh.triangles)
	{
		file.add(std::uint8_t(3));
		for (const uint32_t corner : t) file.add(corner);
	}
	return save(path, file.all().data(), file.all().size());
}

std::string heatMapTable(const HeatMap& map)
{
	std::ostringstream text;
	text.imbue(std::locale::classic());
	text.precision(7);
	text << "part,id,area_m2,dwell_s,mean_force_N,peak_force_N,impulse_Ns,grasps,largest_depth_m,peak_pressure_Pa\n";
	for (const HeatMap::Summary& row : map.summary())
		if (row.dwell > 0)
			text << row.name << ',' << row.id << ',' << row.area << ',' << row.dwell << ',' << row.meanForce << ',' << row.peakForce << ','
				 << row.impulse << ',' << row.grasps << ',' << row.depth << ',' << row.peakPressure << '\n';
	return text.str();
}

std::optional<Error> saveHeatMapTable(const HeatMap& map, const std::string& path)
{
	const std::string text = heatMapTable(map);
	return save(path, reinterpret_cast<const std::byte*>(text.data()), text.size());
}
}  // namespace devicebridge
