// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/ObjForAssimp.h"

#include "BulletISTCollision/Core/Import/Formats/MeshText.h"

#include <algorithm>
#include <charconv>
#include <cstdint>

namespace ist
{
namespace
{
constexpr std::string_view kBlanks = " \t\v\f";

/// The lines of a text, with their ends.
class Lines
{
public:
	explicit Lines(std::string_view text) : m_text(text) {}

	bool next()
	{
		if (m_at >= m_text.size()) return false;
		m_continues = !m_line.empty() && m_content.ends_with('\\') && !endsInHalf();
		size_t end = std::min(m_text.find_first_of("\r\n", m_at), m_text.size());
		m_content = m_text.substr(m_at, end - m_at);
		end += m_text.substr(end, 2) == "\r\n" ? 2 : end < m_text.size();
		m_line = m_text.substr(m_at, end - m_at);
		m_at = end;
		++m_number;
		return true;
	}
	/// The line with its end.
	std::string_view line() const { return m_line; }
	/// The line without its end and without the blanks in front.
	std::string_view content() const { return m_content.substr(std::min(m_content.find_first_not_of(kBlanks), m_content.size())); }
	bool isIndented() const { return !m_continues && m_content.find_first_not_of(kBlanks) != 0 && !content().empty(); }
	/// Whether it belongs to the line before it, which ends with a backslash.
	bool continues() const { return m_continues; }
	/// Whether its last byte is the second half of a character, as in Shift-JIS, and only looks like a backslash.
	bool endsInHalf() const
	{
		return m_content.size() > 1 && m_content.back() == '\\' && static_cast<unsigned char>(m_content[m_content.size() - 2]) >= 0x80;
	}
	size_t number() const { return m_number; }

private:
	std::string_view m_text, m_line, m_content;
	size_t m_at = 0, m_number = 0;
	bool m_continues = false;
};

bool hasKeyword(std::string_view content, std::string_view keyword)
{
	return content.size() > keyword.size() && content.starts_with(keyword) && kBlanks.find(content[keyword.size()]) != kBlanks.npos;
}

/// Takes the next word from the beginning of `rest`, together with the blanks before it.
std::string_view takeWord(std::string_view& rest)
{
	rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
	const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
	rest.remove_prefix(word.size());
	return word;
}

/// The first of the three coordinates of a "v" line that is no number; empty if all are.
std::string_view noNumberIn(std::string_view content)
{
	takeWord(content);
	for (int i = 0; i < 3; ++i)
	{
		std::string_view word = takeWord(content);
		if (word.empty() || word.starts_with('\\') || word.starts_with('#')) return {};
		if (word.ends_with(',') || word.ends_with('\\')) word.remove_suffix(1);
		if (!numberInText(word)) return word;
	}
	return {};
}

bool namesTexture(std::string_view word)
{
	const size_t slash = word.find('/');
	return slash != word.npos && slash + 1 < word.size() && word[slash + 1] != '/';
}

/// "1/2/3" becomes "1//3", and "1/2" becomes "1".
std::string withoutTexture(std::string_view line)
{
	std::string out;
	for (size_t at = 0; at < line.size();)
	{
		const size_t start = std::min(line.find_first_not_of(" \t\v\f\r\n", at), line.size()),
					 end = std::min(line.find_first_of(" \t\v\f\r\n", start), line.size());
		out += line.substr(at, start - at);
		const std::string_view word = line.substr(start, end - start);
		const size_t first = word.find('/'), second = first == word.npos ? first : word.find('/', first + 1);
		if (!namesTexture(word)) out += word;
		else
			out.append(word.substr(0, first)).append(second == word.npos ? "" : "/").append(second == word.npos ? "" : word.substr(second));
		at = end;
	}
	return out;
}

/// Properties of a file that assimp's reader does not expect.
struct Unexpected
{
	bool isIndented = false, hasTexture = false, namesTexture = false, hasFaces = false, hasHalves = false;
};

/// The vertices that faces name by their numbers, from 1 on, or from -1 on back from the last one so far.
class NamedVertices
{
public:
	void addVertex() { ++m_vertices; }
	/// `corner`: "1/2/3". Words that begin with no number are left to assimp.
	std::optional<Error> add(std::string_view corner, size_t line)
	{
		int64_t number = 0;
		if (std::from_chars(corner.data(), corner.data() + corner.size(), number).ec != std::errc()) return std::nullopt;
		if (number == 0 || number < -m_vertices) return missing(number, line);
		if (number > m_largest) m_largest = number, m_line = line;
		return std::nullopt;
	}
	/// A face may name a vertex that comes later in the file.
	std::optional<Error> whatIsMissing() const { return m_largest > m_vertices ? std::optional(missing(m_largest, m_line)) : std::nullopt; }

private:
	Error missing(int64_t number, size_t line) const
	{
		return Error{"the face in line " + std::to_string(line) + " names vertex " + std::to_string(number) + ", and the file has " +
			std::to_string(m_vertices) + (number < 0 ? " before it" : "") + "; it may be cut short: copy or export it again"};
	}
	int64_t m_vertices = 0, m_largest = 0;
	size_t m_line = 0;
};

Result<Unexpected> inspect(std::string_view text)
{
	Unexpected found;
	NamedVertices named;
	bool isFace = false;
	for (Lines lines(text); lines.next();)
	{
		const std::string_view content = lines.content();
		found.isIndented = found.isIndented || lines.isIndented();
		found.hasHalves = found.hasHalves || lines.endsInHalf();
		if (!lines.continues()) isFace = hasKeyword(content, "f");
		for (std::string_view rest = isFace ? content.substr(lines.continues() ? 0 : 1) : ""; !rest.empty();)
			if (auto error = named.add(takeWord(rest), lines.number())) return *error;
		if (lines.continues()) continue;
		if (hasKeyword(content, "v")) named.addVertex();
		found.hasFaces = found.hasFaces || content.starts_with('f');
		found.hasTexture = found.hasTexture || hasKeyword(content, "vt");
		if (const std::string_view word = hasKeyword(content, "v") ? noNumberIn(content) : std::string_view(); !word.empty())
			return Error{quotedText(word) + " in line " + std::to_string(lines.number()) + " is no number; export it again"};
		if (found.hasTexture || found.namesTexture || !hasKeyword(content, "f")) continue;
		std::string_view rest = content;
		while (!rest.empty() && !found.namesTexture) found.namesTexture = namesTexture(takeWord(rest));
	}
	if (const auto error = named.whatIsMissing()) return *error;
	if (!found.hasFaces) return Error{"it has no faces: no line begins with \"f\"; export the surface as polygons"};
	return found;
}
}  // namespace

Result<std::optional<std::string>> objForAssimp(std::string_view bytes)
{
	const std::optional<std::string> converted = needsUtf8(bytes) ? std::optional(utf8Text(bytes)) : std::nullopt;
	const std::string_view text = converted ? std::string_view(*converted) : bytes;
	const Result<Unexpected> found = inspect(text);
	if (!found) return found.error();
	const bool dropsTexture = found.value().namesTexture && !found.value().hasTexture;
	if (!converted && !found.value().isIndented && !found.value().hasHalves && !dropsTexture) return std::optional<std::string>();
	std::string out;
	out.reserve(text.size());
	bool isFace = false;
	for (Lines lines(text); lines.next();)
	{
		std::string_view line = lines.line();
		if (lines.isIndented()) line.remove_prefix(line.find_first_not_of(kBlanks));
		if (!lines.continues()) isFace = hasKeyword(lines.content(), "f");
		if (lines.endsInHalf()) out.append(line.substr(0, line.rfind('\\'))).append(line.substr(line.rfind('\\') + 1));
		else if (isFace && dropsTexture) out += withoutTexture(line);
		else out += line;
	}
	return std::optional(std::move(out));
}

std::vector<Vec3> objVertices(std::string_view text)
{
	std::vector<Vec3> vertices;
	for (Lines lines(text); lines.next();)
	{
		std::string_view content = lines.content();
		if (lines.continues() || !hasKeyword(content, "v")) continue;
		takeWord(content);
		std::vector<double> numbers;
		while (numbers.size() < 5)
		{
			std::string_view word = takeWord(content);
			if (word.ends_with(',')) word.remove_suffix(1);
			const std::optional<double> number = numberInText(word);
			if (!number) break;
			numbers.push_back(*number);
		}
		const double weight = numbers.size() == 4 && numbers[3] != 0 ? numbers[3] : 1;
		numbers.resize(3);
		vertices.push_back(Vec3{numbers[0], numbers[1], numbers[2]} / weight);
	}
	return vertices;
}
}  // namespace ist
