// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/PlyHeader.h"

#include "BulletISTCollision/Core/Import/Formats/MeshText.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace ist
{
namespace
{
constexpr std::string_view kBlanks = " \t\v\f";

std::optional<PlyType> typeNamed(std::string_view name)
{
	static constexpr std::pair<std::string_view, PlyType> kNames[] = {{"char", PlyType::Int8}, {"int8", PlyType::Int8},
		{"uchar", PlyType::Uint8}, {"uint8", PlyType::Uint8}, {"short", PlyType::Int16}, {"int16", PlyType::Int16},
		{"ushort", PlyType::Uint16}, {"uint16", PlyType::Uint16}, {"int", PlyType::Int32}, {"int32", PlyType::Int32},
		{"uint", PlyType::Uint32}, {"uint32", PlyType::Uint32}, {"float", PlyType::Float}, {"float32", PlyType::Float},
		{"double", PlyType::Double}, {"float64", PlyType::Double}};
	for (const auto& [known, type] : kNames)
		if (known == name) return type;
	return std::nullopt;
}

std::vector<std::string_view> wordsOf(std::string_view line)
{
	std::vector<std::string_view> words;
	for (size_t at = 0; (at = line.find_first_not_of(kBlanks, at)) != line.npos;)
	{
		const size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
		words.push_back(line.substr(at, end - at));
		at = end;
	}
	return words;
}

/// The lines of the header. Behind the last one, data follows that may begin with any byte. So each line has the end that the first line
/// has, or a line feed.
class HeaderLines
{
public:
	explicit HeaderLines(std::string_view text) : m_text(text) {}
	bool next()
	{
		const size_t end = m_text.find_first_of("\r\n", m_at);
		if (end == m_text.npos) return false;
		m_line = m_text.substr(m_at, end - m_at);
		const bool isPair = m_text.substr(end, 2) == "\r\n";
		if (m_number++ == 0) m_isOnlyReturn = m_text[end] == '\r' && !isPair;
		m_at = end + (isPair && !m_isOnlyReturn ? 2 : 1);
		return true;
	}
	std::string_view line() const { return m_line; }
	size_t number() const { return m_number; }
	size_t position() const { return m_at; }

private:
	std::string_view m_text, m_line;
	size_t m_at = 0, m_number = 0;
	bool m_isOnlyReturn = false;
};

bool readFormat(const std::vector<std::string_view>& words, PlyHeader& header)
{
	if (words.size() < 2) return false;
	if (words[1] == "ascii") header.format = PlyHeader::Format::Ascii;
	else if (words[1] == "binary_little_endian") header.format = PlyHeader::Format::Little;
	else if (words[1] == "binary_big_endian") header.format = PlyHeader::Format::Big;
	else return false;
	return true;
}

bool readElement(const std::vector<std::string_view>& words, PlyHeader& header)
{
	if (words.size() < 3) return false;
	PlyElement element{std::string(words[1]), 0, {}};
	const char* const last = words[2].data() + words[2].size();
	const auto [end, error] = std::from_chars(words[2].data(), last, element.count);
	if (end != last || error != std::errc()) return false;
	header.elements.push_back(std::move(element));
	return true;
}

bool readProperty(const std::vector<std::string_view>& words, PlyHeader& header)
{
	if (words.size() < 3 || header.elements.empty()) return false;
	const bool isList = words[1] == "list";
	if (isList && words.size() < 5) return false;
	const std::optional<PlyType> type = typeNamed(words[isList ? 3 : 1]), countType = isList ? typeNamed(words[2]) : std::nullopt;
	if (!type || (isList && !countType)) return false;
	header.elements.back().properties.push_back({std::string(words[isList ? 4 : 2]), *type, countType});
	return true;
}
}  // namespace

Result<PlyHeader> readPlyHeader(std::string_view text)
{
	PlyHeader header;
	bool hasFormat = false;
	HeaderLines lines(text);
	while (lines.next())
	{
		const std::vector<std::string_view> words = wordsOf(lines.line());
		const std::string_view keyword = words.empty() ? std::string_view() : words[0];
		bool isKnown = keyword.empty() || keyword == "comment" || keyword == "obj_info";
		if (lines.number() == 1) isKnown = keyword == "ply" || keyword == "PLY";
		else if (keyword == "format") isKnown = hasFormat = readFormat(words, header);
		else if (keyword == "element") isKnown = readElement(words, header);
		else if (keyword == "property") isKnown = readProperty(words, header);
		else if (keyword == "end_header")
		{
			header.end = lines.position();
			if (!hasFormat) return Error{"its header states no format; export the mesh again"};
			return header;
		}
		if (!isKnown)
			return Error{"line " + std::to_string(lines.number()) + " of its header, " + quotedText(lines.line()) +
				", is not PLY; export the mesh again"};
	}
	return Error{"its header has no end; it may be cut short: export the mesh again"};
}
}  // namespace ist
