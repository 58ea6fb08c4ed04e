// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/HeatMapFile.h"

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Mesh/MatchingVertices.h"
#include "DeviceBridge/Hand/HandParts.h"

#include <algorithm>
#include <array>
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

namespace
{
/// What a file contains: vertices with values, and triangles between them.
struct Rows
{
	std::vector<Vec3> places;
	std::vector<HeatMap::Vertex> values;
	std::vector<std::array<uint32_t, 3>> triangles;
	size_t ofFile = 0;  ///< number of vertices, the first ones, that are those of a mesh file
};

std::optional<Error> saveRows(const HeatMap& map, const Rows& rows, const std::string& path, HeatMapColours colours)
{
	const std::vector<HeatMap::Vertex>& values = rows.values;
	const bool hasOthers = rows.ofFile > 0 && rows.ofFile < values.size();
	Bytes file;
	file.add("ply\nformat binary_little_endian 1.0\ncomment lengths in metres; part is the label of GRAB, 0 for none\ncomment grasps " +
		std::to_string(map.grasps()) + "\n");
	file.add("element vertex " + std::to_string(values.size()) + "\nproperty float x\nproperty float y\nproperty float z\n");
	file.add("property uchar red\nproperty uchar green\nproperty uchar blue\n");
	file.add("property float contact\nproperty float dwell\nproperty float impulse\nproperty float pressure\nproperty float "
			 "peak_pressure\nproperty int part\n");
	if (hasOthers) file.add("property int file_vertex\n");
	file.add("element face " + std::to_string(rows.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n");
	for (size_t i = 0; i < values.size(); ++i)
	{
		const HeatMap::Vertex& v = values[i];
		const Vec3& p = rows.places[i];
		file.add(i == 0 ? notALineBreak(float(p.x)) : float(p.x));
		file.add(float(p.y)), file.add(float(p.z));
		const HeatMapColour colour = heatMapColour(map, v, colours);
		file.add(colour.r), file.add(colour.g), file.add(colour.b);
		for (const double x : {v.contact, v.dwell, v.impulse, v.pressure, v.peak}) file.add(float(x));
		file.add(std::uint32_t(v.part < 0 ? 0 : map.partId(v.part)));
		if (hasOthers) file.add(i < rows.ofFile ? std::uint32_t(i) : std::uint32_t(-1));
	}
	for (const auto& t : rows.triangles)
	{
		file.add(std::uint8_t(3));
		for (const uint32_t corner : t) file.add(corner);
	}
	return save(path, file.all().data(), file.all().size());
}

std::optional<Error> noSuchPart(const HeatMap& map, int part)
{
	if (part < map.parts()) return std::nullopt;
	return Error{"the heat map has no part " + std::to_string(part) + ", only " + std::to_string(map.parts())};
}
}  // namespace

std::optional<Error> saveHeatMap(const HeatMap& map, const std::string& path, HeatMapColours colours, int part)
{
	if (auto error = noSuchPart(map, part)) return error;
	return saveRows(map, {map.mesh().vertices, map.vertices(part), map.mesh().triangles, 0}, path, colours);
}

std::optional<Error> saveHeatMapOfFile(
	const HeatMap& map, const std::vector<Vec3>& file, const std::string& path, HeatMapColours colours, int part)
{
	if (auto error = noSuchPart(map, part)) return error;
	const Mesh& mesh = map.mesh();
	const std::vector<int64_t> matching = matchingVertices(file, mesh, weldingTolerance(mesh));
	const std::vector<HeatMap::Vertex> values = map.vertices(part);
	constexpr uint32_t kNone = UINT32_MAX;
	std::vector<uint32_t> rowOf(mesh.vertices.size(), kNone);
	Rows rows{file, std::vector<HeatMap::Vertex>(file.size()), mesh.triangles, file.size()};
	bool some = false;
	for (size_t i = 0; i < matching.size(); ++i)
	{
		if (matching[i] < 0) continue;
		const auto vertex = size_t(matching[i]);
		some = true;
		rows.values[i] = values[vertex];
		if (rowOf[vertex] == kNone) rowOf[vertex] = uint32_t(i);
	}
	if (!some)
		return Error{"none of the " + std::to_string(file.size()) +
			" vertices of the file is a vertex of the heat map; move and scale them as its mesh was, and do not rebuild it on a grid"};
	for (size_t v = 0; v < rowOf.size(); ++v)
	{
		if (rowOf[v] != kNone) continue;
		rowOf[v] = uint32_t(rows.places.size());
		rows.places.push_back(mesh.vertices[v]);
		rows.values.push_back(values[v]);
	}
	for (auto& t : rows.triangles)
		for (uint32_t& corner : t) corner = rowOf[corner];
	return saveRows(map, rows, path, colours);
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
