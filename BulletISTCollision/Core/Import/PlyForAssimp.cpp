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

/// The first element before the faces that assimp does not know; empty if there is none.
std::string unknownElement(std::string_view head)
{
	for (size_t at = 0; (at = head.find(kElement, at)) != head.npos;)
	{
		const bool startsLine = at == 0 || kLineEnds.find(head[at - 1]) != kLineEnds.npos;
		at += kElement.size();
		const std::string_view name = head.substr(at, std::min(head.find_first_of(" \t\r\n", at), head.size()) - at);
		if (!startsLine) continue;
		if (name == "face") break;
		if (std::ranges::find(kKnown, name) == kKnown.end()) return std::string(name);
	}
	return {};
}
}  // namespace

Result<std::optional<std::string>> plyForAssimp(std::string_view bytes)
{
	const std::optional<std::string> same;
	if (needsUtf8(bytes)) return std::optional(withoutIndentation(utf8Text(bytes)));
	const size_t end = bytes.find(kEndOfHead);
	if (end == bytes.npos) return same;
	const std::string_view head = bytes.substr(0, end);
	if (head.find(kBinary) == head.npos) return isIndented(bytes) ? std::optional(withoutIndentation(bytes)) : same;
	if (const std::string name = unknownElement(head); !name.empty())
		return Error{"it is binary and has an element \"" + name +
			"\" before its faces, which the reader does not know; export it without that, or as ASCII"};
	size_t body = end + kEndOfHead.size();
	body += bytes.substr(body, 2) == kLineEnds ? 2 : 1;
	const size_t element = head.find(kElement);
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
}  // namespace ist
