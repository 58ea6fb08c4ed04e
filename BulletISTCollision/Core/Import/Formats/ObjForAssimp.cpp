// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/ObjForAssimp.h"

#include "BulletISTCollision/Core/Import/Formats/MeshText.h"

#include <algorithm>

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
		m_continues = !m_line.empty() && m_content.ends_with('\\');
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
	bool isIndented = false, hasTexture = false, namesTexture = false;
};

Result<Unexpected> inspect(std::string_view text)
{
	Unexpected found;
	for (Lines lines(text); lines.next();)
	{
		const std::string_view content = lines.content();
		found.isIndented = found.isIndented || lines.isIndented();
		if (lines.continues()) continue;
		found.hasTexture = found.hasTexture || hasKeyword(content, "vt");
		if (const std::string_view word = hasKeyword(content, "v") ? noNumberIn(content) : std::string_view(); !word.empty())
			return Error{quotedText(word) + " in line " + std::to_string(lines.number()) + " is no number; export it again"};
		if (found.hasTexture || found.namesTexture || !hasKeyword(content, "f")) continue;
		std::string_view rest = content;
		while (!rest.empty() && !found.namesTexture) found.namesTexture = namesTexture(takeWord(rest));
	}
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
	if (!converted && !found.value().isIndented && !dropsTexture) return std::optional<std::string>();
	std::string out;
	out.reserve(text.size());
	bool isFace = false;
	for (Lines lines(text); lines.next();)
	{
		std::string_view line = lines.line();
		if (lines.isIndented()) line.remove_prefix(line.find_first_not_of(kBlanks));
		if (!lines.continues()) isFace = hasKeyword(lines.content(), "f");
		if (isFace && dropsTexture) out += withoutTexture(line);
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
