// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/PlyFile.h"

#include "BulletISTCollision/Core/Import/Formats/ImportCancelled.h"
#include "BulletISTCollision/Core/Import/Formats/LeftOut.h"
#include "BulletISTCollision/Core/Import/Formats/MeshText.h"
#include "BulletISTCollision/Core/Import/Formats/PlyHeader.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Core/Mesh/PolygonDivision.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
/// Elements between two calls of the progress callback, or, where faces are divided, the sum of the squares of their numbers of corners.
constexpr uint64_t kBetweenCalls = 1 << 16;
/// The index of a corner that cannot be one.
constexpr uint32_t kNoVertex = UINT32_MAX;

size_t sizeOf(PlyType type)
{
	switch (type)
	{
	case PlyType::Int8:
	case PlyType::Uint8: return 1;
	case PlyType::Int16:
	case PlyType::Uint16: return 2;
	case PlyType::Double: return 8;
	default: return 4;
	}
}

/// The numbers behind the header, one after the other.
class PlyNumbers
{
public:
	PlyNumbers(std::string_view bytes, const PlyHeader& header) : m_bytes(bytes), m_format(header.format), m_at(header.end) {}

	/// The next number; empty if there is none, or if the next word is no number.
	std::optional<double> next(PlyType type) { return m_format == PlyHeader::Format::Ascii ? nextWord(type) : nextBytes(type); }

	size_t position() const { return m_at; }
	size_t left() const { return m_bytes.size() - m_at; }
	/// Why the reading ended early: the last next() was empty, or what refuse() said.
	const std::string& problem() const { return m_problem; }
	void refuse(std::string problem) { m_problem = std::move(problem); }
	/// Number of bytes that are left, without blanks around them.
	size_t unread() const
	{
		const size_t begin = m_bytes.find_first_not_of(kBlanks, m_at);
		return begin == m_bytes.npos ? 0 : m_bytes.find_last_not_of(kBlanks) + 1 - begin;
	}

private:
	static constexpr std::string_view kBlanks = " \t\v\f\r\n";

	std::optional<double> nextWord(PlyType type)
	{
		const size_t begin = std::min(m_bytes.find_first_not_of(kBlanks, m_at), m_bytes.size()),
					 end = std::min(m_bytes.find_first_of(kBlanks, begin), m_bytes.size());
		m_at = end;
		if (begin == end) return std::nullopt;
		const std::optional<double> number = numberInText(m_bytes.substr(begin, end - begin));
		if (!number) refuse(quotedText(m_bytes.substr(begin, end - begin)) + " is no number in it");
		return number && type == PlyType::Float ? std::optional(double(float(*number))) : number;
	}

	std::optional<double> nextBytes(PlyType type)
	{
		const size_t size = sizeOf(type);
		if (left() < size)
		{
			m_at = m_bytes.size();
			return std::nullopt;
		}
		uint64_t word = 0;
		for (size_t i = 0; i < size; ++i)
		{
			const size_t shift = m_format == PlyHeader::Format::Little ? i : size - 1 - i;
			word |= uint64_t(static_cast<unsigned char>(m_bytes[m_at + i])) << 8 * shift;
		}
		m_at += size;
		switch (type)
		{
		case PlyType::Int8: return double(int8_t(uint8_t(word)));
		case PlyType::Int16: return double(int16_t(uint16_t(word)));
		case PlyType::Int32: return double(int32_t(uint32_t(word)));
		case PlyType::Float: return double(std::bit_cast<float>(uint32_t(word)));
		case PlyType::Double: return std::bit_cast<double>(word);
		default: return double(word);
		}
	}

	std::string_view m_bytes;
	PlyHeader::Format m_format;
	size_t m_at;
	std::string m_problem = "it is cut short";
};

uint32_t vertexOf(double value)
{
	return value >= 0 && value < double(kNoVertex) && value == std::floor(value) ? uint32_t(value) : kNoVertex;
}

/// A face as stored: its corners begin at `corners`, and its texture coordinates, two for each corner if all are there, at `places`.
struct PlyFace
{
	size_t corners = 0, count = 0;
	size_t places = 0, placeNumbers = 0;
};

class PlyReader
{
public:
	PlyReader(std::string_view bytes, const PlyHeader& header, const std::function<bool(double)>& goesOn)
		: m_header(header),
		  m_numbers(bytes, header),
		  m_goesOn(goesOn),
		  m_size(bytes.size())
	{}

	Result<PlySurface> read()
	{
		for (const PlyElement& element : m_header.elements)
			if (auto error = readElement(element)) return *error;
		if (!m_hasVertices) return Error{"it has no element \"vertex\" with the properties x, y and z; export the surface as polygons"};
		return surface();
	}

private:
	/// What is made of the values of an element.
	enum class Kind
	{
		Vertex,
		Face,
		Strips,
		Other
	};
	/// A second element of vertices would have other properties, and is skipped.
	Kind kindOf(const PlyElement& element) const
	{
		if (element.name == "vertex") return m_hasVertices ? Kind::Other : Kind::Vertex;
		if (element.name == "face") return Kind::Face;
		return element.name == "tristrips" ? Kind::Strips : Kind::Other;
	}

	std::optional<Error> readElement(const PlyElement& element)
	{
		if (element.properties.empty()) return std::nullopt;
		const Kind kind = kindOf(element);
		if (kind == Kind::Vertex) beginVertices(element);
		for (uint64_t i = 0; i < element.count; ++i)
		{
			if (m_goesOn && i % kBetweenCalls == 0 && !m_goesOn(double(m_numbers.position()) / double(m_size))) return importCancelled();
			if (!readRow(element, kind))
				return Error{m_numbers.problem() + ", in element " + std::to_string(i + 1) + " of the " + std::to_string(element.count) +
					" " + quotedText(element.name) + " that its header states; export the mesh again"};
		}
		return std::nullopt;
	}

	void beginVertices(const PlyElement& element)
	{
		const auto find = [&](std::initializer_list<const char*> names) {
			for (size_t i = 0; i < element.properties.size(); ++i)
				for (const char* name : names)
					if (element.properties[i].name == name && !element.properties[i].countType) return i;
			return element.properties.size();
		};
		m_columns = {find({"x"}), find({"y"}), find({"z"}), find({"u", "s", "texture_u"}), find({"v", "t", "texture_v"})};
		const auto has = [&](size_t i) { return m_columns[i] < element.properties.size(); };
		m_hasVertices = has(0) && has(1) && has(2);
		m_hasPlaces = has(3) && has(4);
		m_surface.isDouble = m_hasVertices && element.properties[m_columns[0]].type == PlyType::Double;
	}

	bool readRow(const PlyElement& element, Kind kind)
	{
		std::array<double, 5> values{};
		PlyFace face;
		for (size_t i = 0; i < element.properties.size(); ++i)
		{
			const PlyProperty& property = element.properties[i];
			if (property.countType)
			{
				if (!readList(property)) return false;
				if (kind == Kind::Face) takeList(property, face);
				if (kind == Kind::Strips && isCorners(property)) takeStrips();
				continue;
			}
			const std::optional<double> value = m_numbers.next(property.type);
			if (!value) return false;
			if (kind == Kind::Vertex)
				for (size_t column = 0; column < values.size(); ++column)
					if (m_columns[column] == i) values[column] = *value;
		}
		if (kind == Kind::Vertex && m_hasVertices)
		{
			m_surface.textured.mesh.vertices.push_back({values[0], values[1], values[2]});
			if (m_hasPlaces) m_places.push_back({values[3], values[4]});
		}
		if (kind == Kind::Face && face.count > 0) m_faces.push_back(face);
		return true;
	}

	bool readList(const PlyProperty& property)
	{
		m_list.clear();
		const std::optional<double> count = m_numbers.next(*property.countType);
		// Each item takes a byte or more, so that a longer list is damaged.
		if (count && !(*count >= 0)) m_numbers.refuse("a list in it has " + number(*count) + " items");
		if (!count || !(*count >= 0) || *count > double(m_numbers.left())) return false;
		for (double i = 0; i < *count; ++i)
		{
			const std::optional<double> item = m_numbers.next(property.type);
			if (!item) return false;
			m_list.push_back(*item);
		}
		return true;
	}

	static bool isCorners(const PlyProperty& property) { return property.name == "vertex_indices" || property.name == "vertex_index"; }

	void takeList(const PlyProperty& property, PlyFace& face)
	{
		if (isCorners(property))
		{
			face.corners = m_corners.size();
			face.count = m_list.size();
			for (const double corner : m_list) m_corners.push_back(vertexOf(corner));
		}
		else if (property.name == "texcoord")
		{
			face.places = m_facePlaces.size();
			face.placeNumbers = m_list.size();
			m_facePlaces.insert(m_facePlaces.end(), m_list.begin(), m_list.end());
			m_hasFacePlaces = true;
		}
	}

	/// Each index behind the second one of a strip makes a triangle with the two before it, whose side changes from one to the next. A
	/// negative index ends a strip, and triangles with equal corners only lead on.
	void takeStrips()
	{
		size_t inStrip = 0;
		for (size_t i = 0; i < m_list.size(); ++i)
		{
			inStrip = m_list[i] < 0 ? 0 : inStrip + 1;
			if (inStrip < 3) continue;
			const bool isOdd = inStrip % 2 == 0;
			const std::array<double, 3> t = {m_list[i - 2 + isOdd], m_list[i - 1 - isOdd], m_list[i]};
			if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
			m_faces.push_back({m_corners.size(), 3});
			for (const double corner : t) m_corners.push_back(vertexOf(corner));
		}
	}

	Result<PlySurface> surface()
	{
		LeftOut leftOut;
		const std::vector<Vec3>& vertices = m_surface.textured.mesh.vertices;
		uint64_t work = 0;
		for (const PlyFace& face : m_faces)
		{
			work += uint64_t(face.count) * face.count;
			if (m_goesOn && work >= kBetweenCalls)
			{
				if (!m_goesOn(1)) return importCancelled();
				work = 0;
			}
			const std::span<const uint32_t> corners(m_corners.data() + face.corners, face.count);
			if (leftOut.takes(corners.size(), std::ranges::all_of(corners, [&](uint32_t c) { return c < vertices.size(); })))
				append(corners, face);
		}
		if (const auto sentence = leftOut.tooDamaged()) return Error{*sentence};
		m_surface.textured.mesh.notTaken = leftOut.sentences();
		if (const size_t unread = m_numbers.unread())
			m_surface.textured.mesh.notTaken.push_back(
				counted(int64_t(unread), "byte") + " behind the elements that the header states were left out.");
		return std::move(m_surface);
	}

	void append(std::span<const uint32_t> corners, const PlyFace& face)
	{
		TexturedMesh& textured = m_surface.textured;
		m_polygon.clear();
		for (const uint32_t corner : corners) m_polygon.push_back(textured.mesh.vertices[corner]);
		for (const std::array<size_t, 3>& t : dividedPolygon(m_polygon))
		{
			textured.mesh.triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
			if (m_hasFacePlaces) textured.places.push_back({facePlace(face, t[0]), facePlace(face, t[1]), facePlace(face, t[2])});
			else if (m_hasPlaces) textured.places.push_back({m_places[corners[t[0]]], m_places[corners[t[1]]], m_places[corners[t[2]]]});
		}
	}

	/// NaN where a face lacks the coordinates that others have.
	TexturePlace facePlace(const PlyFace& face, size_t corner) const
	{
		const double nan = std::numeric_limits<double>::quiet_NaN();
		const size_t at = face.places + 2 * corner;
		return 2 * corner + 1 < face.placeNumbers ? TexturePlace{m_facePlaces[at], m_facePlaces[at + 1]} : TexturePlace{nan, nan};
	}

	const PlyHeader& m_header;
	PlyNumbers m_numbers;
	const std::function<bool(double)>& m_goesOn;
	size_t m_size;
	PlySurface m_surface;
	bool m_hasVertices = false, m_hasPlaces = false, m_hasFacePlaces = false;
	std::array<size_t, 5> m_columns{};  // of x, y, z, u and v among the properties of the vertices
	std::vector<TexturePlace> m_places;
	std::vector<PlyFace> m_faces;
	std::vector<uint32_t> m_corners;
	std::vector<double> m_facePlaces, m_list;
	std::vector<Vec3> m_polygon;
};
}  // namespace

Result<PlySurface> readPly(std::string_view bytes, const std::function<bool(double)>& goesOn)
{
	const std::optional<std::string> converted = needsUtf8(bytes) ? std::optional(utf8Text(bytes)) : std::nullopt;
	const std::string_view text = converted ? std::string_view(*converted) : bytes;
	const Result<PlyHeader> header = readPlyHeader(text);
	if (!header) return header.error();
	return PlyReader(text, header.value(), goesOn).read();
}
}  // namespace ist
