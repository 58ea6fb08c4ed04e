// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/StlFile.h"

#include "BulletISTCollision/Core/Import/Formats/ImportCancelled.h"
#include "BulletISTCollision/Core/Import/Formats/MeshText.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace ist
{
namespace
{
constexpr size_t kHeader = 80, kFirstTriangle = 84, kTriangle = 50;
/// Triangles between two calls of the progress callback.
constexpr size_t kBetweenCalls = 1 << 16;
/// The count in the header of a file that was written without knowing its number of triangles.
constexpr uint32_t kUnknownCount = 0xffffffff;

using GoesOn = std::function<bool(double)>;

std::string counted(uint64_t n, const char* thing) { return std::to_string(n) + " " + thing + (n == 1 ? "" : "s"); }

uint32_t wordAt(std::string_view bytes, size_t at)
{
	uint32_t word = 0;
	for (size_t i = 0; i < 4; ++i) word |= static_cast<uint32_t>(static_cast<unsigned char>(bytes[at + i])) << 8 * i;
	return word;
}

/// Rounded to single precision; infinite if it is too large for that.
double single(double v) { return static_cast<double>(static_cast<float>(v)); }

void append(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c)
{
	const auto first = static_cast<uint32_t>(mesh.vertices.size());
	mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
	mesh.triangles.push_back({first, first + 1, first + 2});
}

Result<Mesh> readTriangles(std::string_view bytes, size_t count, const GoesOn& goesOn)
{
	Mesh mesh;
	mesh.vertices.reserve(3 * count);
	mesh.triangles.reserve(count);
	for (size_t i = 0; i < count; ++i)
	{
		const size_t corners = kFirstTriangle + i * kTriangle + 12;
		const auto number = [&](size_t k) { return static_cast<double>(std::bit_cast<float>(wordAt(bytes, corners + 4 * k))); };
		append(mesh, {number(0), number(1), number(2)}, {number(3), number(4), number(5)}, {number(6), number(7), number(8)});
		if (goesOn && i % kBetweenCalls == 0 && !goesOn(double(i) / double(count))) return importCancelled();
	}
	return mesh;
}

/// Whether each edge of the first `count` triangles runs the other way in another one of them. Positions are compared exactly.
bool isClosed(const Mesh& mesh, size_t count)
{
	const auto key = [](const Vec3& p) { return std::array{p.x, p.y, p.z}; };
	using Corner = std::array<double, 3>;
	std::map<std::pair<Corner, Corner>, int> open;
	for (size_t n = 0; n < count; ++n)
		for (size_t i = 0; i < 3; ++i)
		{
			const auto& t = mesh.triangles[n];
			const Corner from = key(mesh.vertices[t[i]]), to = key(mesh.vertices[t[(i + 1) % 3]]);
			if (from == to) continue;
			from < to ? ++open[{from, to}] : --open[{to, from}];
		}
	return count > 0 && std::ranges::all_of(open, [](const auto& edge) { return edge.second == 0; });
}

bool isText(std::string_view bytes)
{
	return std::ranges::all_of(bytes, [](unsigned char c) { return c >= ' ' || std::isspace(c); });
}

bool isPadding(std::string_view bytes)
{
	return std::ranges::all_of(bytes, [](char c) { return c == 0; });
}

std::string countTaken(uint64_t count, uint64_t room)
{
	return "The header counts " + counted(count, "triangle") + ", and the file has room for " + std::to_string(room) +
		": all in the file were taken; export the mesh again.";
}

Result<Mesh> readBinary(std::string_view bytes, const GoesOn& goesOn)
{
	const uint64_t count = wordAt(bytes, kHeader), room = (bytes.size() - kFirstTriangle) / kTriangle,
				   rest = (bytes.size() - kFirstTriangle) % kTriangle;
	if (count <= room)
	{
		const std::string_view behind = bytes.substr(kFirstTriangle + count * kTriangle);
		bool isLeftOut = behind.size() < kTriangle || (count > 0 && (isText(behind) || isPadding(behind)));
		Result<Mesh> mesh = readTriangles(bytes, isLeftOut ? count : room, goesOn);
		if (!mesh || behind.empty()) return mesh;
		if (!isLeftOut && isClosed(mesh.value(), count))
		{
			// The counted triangles are a whole surface, so that what follows is a footer.
			isLeftOut = true;
			mesh.value().vertices.resize(3 * count);
			mesh.value().triangles.resize(count);
		}
		mesh.value().notTaken.push_back(isLeftOut
				? counted(behind.size(), "byte") + " behind the last triangle " + (behind.size() == 1 ? "was" : "were") + " left out."
				: countTaken(count, room));
		return mesh;
	}
	const std::string wrong = "its header counts " + counted(count, "triangle") + ", and the file has room for " + std::to_string(room);
	if (rest != 0 || room == 0) return Error{wrong + ", so it is cut short: copy or export it again"};
	Result<Mesh> mesh = readTriangles(bytes, room, goesOn);
	if (!mesh) return mesh;
	if (count != kUnknownCount && !isClosed(mesh.value(), room))
		return Error{wrong + ", which enclose nothing, so it is cut short: copy or export it again"};
	mesh.value().notTaken.push_back(countTaken(count, room));
	return mesh;
}

/// The words of a text.
class Words
{
public:
	explicit Words(std::string_view text) : m_text(text) {}

	/// The next word; empty at the end of the text.
	std::string_view next()
	{
		while (m_at < m_text.size() && isBlank(m_text[m_at])) ++m_at;
		const size_t start = m_at;
		while (m_at < m_text.size() && !isBlank(m_text[m_at])) ++m_at;
		return m_text.substr(start, m_at - start);
	}
	/// Goes back to the beginning of a word.
	void putBack(std::string_view word) { m_at = positionOf(word); }
	/// Skips a name. It ends with its line, or before "facet" if a whole facet follows in this line.
	/// Cost of all calls together: O(size of the text), because the ends of the line and of the facet are remembered.
	void skipName()
	{
		if (m_lineEnd < m_at) m_lineEnd = std::min(m_text.find_first_of("\r\n", m_at), m_text.size());
		const std::string_view facet = nextInLine("facet");
		if (!facet.empty() && m_facetEnd <= m_at)
		{
			const std::string_view end = nextInLine("endfacet");
			m_facetEnd = end.empty() ? 0 : positionOf(end);
		}
		if (!facet.empty() && m_facetEnd > positionOf(facet)) return putBack(facet);
		m_at = m_lineEnd;
	}
	double share() const { return m_text.empty() ? 1 : double(m_at) / double(m_text.size()); }
	/// Counted from 1. Cost: O(size of the text).
	size_t line() const
	{
		size_t lines = 1;
		for (size_t i = 0; i < m_at; ++i)
			lines += m_text[i] == '\n' || (m_text[i] == '\r' && (i + 1 >= m_text.size() || m_text[i + 1] != '\n'));
		return lines;
	}
	static std::string lower(std::string_view word)
	{
		std::string text(word);
		std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
		return text;
	}

private:
	static bool isBlank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0 || c == 0; }
	size_t positionOf(std::string_view word) const { return static_cast<size_t>(word.data() - m_text.data()); }
	/// The next such word before m_lineEnd, in lower or upper case; empty if there is none.
	std::string_view nextInLine(std::string_view wanted)
	{
		for (;;)
		{
			const std::string_view word = next();
			if (word.empty() || positionOf(word) >= m_lineEnd) return {};
			if (lower(word) == wanted) return word;
		}
	}

	std::string_view m_text;
	size_t m_at = 0;
	size_t m_lineEnd = 0;   ///< the first line end at or behind the position of the last call of skipName()
	size_t m_facetEnd = 0;  ///< position of the "endfacet" that skipName() found last
};

/// Reads a text, facet by facet.
class AsciiReader
{
public:
	explicit AsciiReader(std::string_view text) : m_words(text) {}

	Result<Mesh> read(const GoesOn& goesOn)
	{
		for (size_t i = 0;; ++i)
		{
			const std::string word = Words::lower(m_words.next());
			if (word.empty()) break;
			take(word);
			if (goesOn && i % kBetweenCalls == 0 && !goesOn(m_words.share())) return importCancelled();
		}
		const bool isCut = m_inFacet;
		endFacet();
		if (!m_isStl)
			return Error{
				"it has neither the facets of an ASCII STL file nor the length of a binary one; it may be cut short, or of another "
				"format than its name ends with: export it again"};
		if (2 * m_damaged > m_facets)
			return Error{std::to_string(m_damaged) + " of its " + counted(m_facets, "facet") +
				" have fewer than three corners, or corners that are no numbers, the first in line " + std::to_string(m_firstLine) +
				"; export it again"};
		say(isCut);
		return std::move(m_mesh);
	}

private:
	void take(const std::string& word)
	{
		if (word == "solid" || word == "endsolid")
		{
			endFacet();
			m_isStl = m_isStl || word == "endsolid";
			m_isEnded = word == "endsolid";
			m_words.skipName();
		}
		else if (word == "facet")
		{
			endFacet();
			m_inFacet = m_isStl = true;
		}
		else if (word == "vertex" && m_inFacet) takeCorner();
		else if (word == "endfacet") endFacet();
	}

	void takeCorner()
	{
		Vec3 p;
		for (double* v : {&p.x, &p.y, &p.z})
		{
			const std::string_view word = m_words.next();
			const std::optional<double> number = numberInText(word.ends_with(',') ? word.substr(0, word.size() - 1) : word);
			if (!number)
			{
				m_words.putBack(word);
				m_isDamaged = true;
				return;
			}
			*v = single(*number);
		}
		m_corners.push_back(p);
	}

	void endFacet()
	{
		if (!m_inFacet) return;
		++m_facets;
		if (m_isDamaged || m_corners.size() < 3)
		{
			if (m_damaged++ == 0) m_firstLine = m_words.line();
		}
		else
		{
			m_polygons += m_corners.size() > 3;
			for (size_t i = 2; i < m_corners.size(); ++i) append(m_mesh, m_corners[0], m_corners[i - 1], m_corners[i]);
		}
		m_corners.clear();
		m_inFacet = m_isDamaged = false;
	}

	void say(bool isCut)
	{
		if (m_damaged)
			m_mesh.notTaken.push_back(std::to_string(m_damaged) + " of " + counted(m_facets, "facet") +
				(m_damaged == 1 ? " was left out: it has" : " were left out: they have") +
				" fewer than three corners, or corners that are no numbers, the first in line " + std::to_string(m_firstLine) +
				"; export the mesh again.");
		if (m_polygons)
			m_mesh.notTaken.push_back(counted(m_polygons, "facet") + (m_polygons == 1 ? " has" : " have") +
				" more than three corners, which STL does not allow; triangles were made from the first corner.");
		if (isCut || !m_isEnded)
			m_mesh.notTaken.push_back("The file ends without \"endsolid\": it may be cut short; copy or export it again.");
	}

	Words m_words;
	Mesh m_mesh;
	std::vector<Vec3> m_corners;
	uint64_t m_facets = 0, m_damaged = 0, m_polygons = 0;
	size_t m_firstLine = 0;
	bool m_isStl = false, m_isEnded = false, m_inFacet = false, m_isDamaged = false;
};

bool hasLengthOfItsCount(std::string_view bytes)
{
	return bytes.size() >= kFirstTriangle && bytes.size() == kFirstTriangle + uint64_t(kTriangle) * wordAt(bytes, kHeader);
}
}  // namespace

Result<Mesh> readStl(std::string_view bytes, const GoesOn& goesOn)
{
	if (hasLengthOfItsCount(bytes)) return readBinary(bytes, goesOn);
	if (needsUtf8(bytes)) return AsciiReader(utf8Text(bytes)).read(goesOn);
	const bool isAscii = bytes.substr(0, kFirstTriangle).find('\0') == bytes.npos;
	if (!isAscii && bytes.size() < kFirstTriangle)
		return Error{"its " + counted(bytes.size(), "byte") +
			" are fewer than the header of a binary STL file has, so it is cut short: copy or "
			"export it again"};
	return isAscii ? AsciiReader(bytes).read(goesOn) : readBinary(bytes, goesOn);
}
}  // namespace ist
