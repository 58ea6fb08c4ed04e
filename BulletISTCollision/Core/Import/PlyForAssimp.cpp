// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/PlyForAssimp.h"

#include "BulletISTCollision/Core/Import/MeshText.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace ist
{
namespace
{
constexpr std::string_view kEndOfHead = "end_header", kBinary = "format binary", kElement = "element ";
constexpr std::string_view kLineEnds = "\r\n", kBlanks = " \t";
/// An element of one byte that stands before all others. Its name is one of those that assimp knows.
constexpr std::string_view kFiller = "element material 1\nproperty uchar red\n";
constexpr std::array<std::string_view, 4> kKnown = {"vertex", "tristrips", "edge", "material"};

bool isBlank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

/// Removes the blanks before each line.
std::string withoutIndentation(std::string_view text)
{
	std::string out;
	out.reserve(text.size());
	for (size_t at = 0; at < text.size();)
	{
		const size_t start = std::min(text.find_first_not_of(kBlanks, at), text.size()),
					 end = std::min(text.find_first_of(kLineEnds, start), text.size()),
					 next = std::min(text.find_first_not_of(kLineEnds, end), text.size());
		out += text.substr(start, next - start);
		at = next;
	}
	return out;
}

bool isIndented(std::string_view text)
{
	return !text.empty() && (kBlanks.find(text[0]) != kBlanks.npos || text.find("\n ") != text.npos || text.find("\n\t") != text.npos);
}

/// The position of a word that is the first of its line, at or after `from`; npos if there is none.
size_t findFirstWord(std::string_view text, std::string_view word, size_t from = 0)
{
	for (size_t at = from; (at = text.find(word, at)) != text.npos; at += word.size())
	{
		const size_t before = text.substr(0, at).find_last_not_of(kBlanks);
		if (before == text.npos || kLineEnds.find(text[before]) != kLineEnds.npos) return at;
	}
	return text.npos;
}

/// The first element before the faces that assimp does not know; empty if there is none.
std::string unknownElement(std::string_view head)
{
	for (size_t at = 0; (at = findFirstWord(head, kElement, at)) != head.npos;)
	{
		at += kElement.size();
		const std::string_view name = head.substr(at, std::min(head.find_first_of(" \t\r\n", at), head.size()) - at);
		if (name == "face") break;
		if (std::ranges::find(kKnown, name) == kKnown.end()) return std::string(name);
	}
	return {};
}

/// The position behind the line end of the last line of the head. Blanks may stand before the line end.
size_t bodyOf(std::string_view bytes, size_t endOfHead)
{
	const size_t at = bytes.find_first_not_of(kBlanks, endOfHead);
	if (at == bytes.npos || kLineEnds.find(bytes[at]) == kLineEnds.npos) return bytes.size();
	return at + (bytes.substr(at, 2) == kLineEnds ? 2 : 1);
}

/// What plyForAssimp() returns, for a file without a byte order mark.
Result<std::optional<std::string>> plainForAssimp(std::string_view bytes)
{
	const std::optional<std::string> same;
	const size_t end = findFirstWord(bytes, kEndOfHead);
	if (end == bytes.npos) return same;
	const std::string_view head = bytes.substr(0, end);
	if (findFirstWord(head, kBinary) == head.npos) return isIndented(bytes) ? std::optional(withoutIndentation(bytes)) : same;
	if (const std::string name = unknownElement(head); !name.empty())
		return Error{"it is binary and has an element \"" + name +
			"\" before its faces, which the reader does not know; export it without that, or as ASCII"};
	const size_t body = bodyOf(bytes, end + kEndOfHead.size()), element = findFirstWord(head, kElement);
	if (body >= bytes.size() || !isBlank(bytes[body]) || element == head.npos) return same;
	std::string out;
	out.reserve(bytes.size() + kFiller.size() + 1);
	out.append(bytes.substr(0, element))
		.append(kFiller)
		.append(bytes.substr(element, body - element))
		.append("x")
		.append(bytes.substr(body));
	return std::optional(std::move(out));
}
}  // namespace

Result<std::optional<std::string>> plyForAssimp(std::string_view bytes)
{
	if (!needsUtf8(bytes)) return plainForAssimp(bytes);
	std::string text = utf8Text(bytes);
	Result<std::optional<std::string>> changed = plainForAssimp(text);
	if (!changed || changed.value()) return changed;
	return std::optional(std::move(text));
}
}  // namespace ist
