// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/XmlTags.h"

#include <algorithm>
#include <utility>

namespace ist
{
namespace
{
constexpr std::string_view kBlanks = " \t\r\n";

std::string withoutEntities(std::string_view text)
{
	static constexpr std::pair<std::string_view, char> kEntities[] = {
		{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
	if (text.find('&') == text.npos) return std::string(text);
	std::string out;
	while (!text.empty())
	{
		const auto entity = std::find_if(
			std::begin(kEntities), std::end(kEntities), [&](const auto& e) { return text.starts_with(e.first); });
		const bool found = entity != std::end(kEntities);
		out += found ? entity->second : text.front();
		text.remove_prefix(found ? entity->first.size() : 1);
	}
	return out;
}
}  // namespace

bool XmlTags::skipTo(std::string_view end)
{
	const size_t found = m_text.find(end, m_at);
	m_at = found == m_text.npos ? m_text.size() : found + end.size();
	return found != m_text.npos;
}

bool XmlTags::skipDeclaration()
{
	// A document type declaration may contain declarations between brackets.
	const size_t end = m_text.find('>', m_at);
	if (end == m_text.npos) return false;
	const bool hasBracket = m_text.substr(m_at, end - m_at).find('[') != m_text.npos;
	if (hasBracket && !skipTo("]")) return false;
	return skipTo(">");
}

bool XmlTags::takeStartTag()
{
	const size_t first = m_at;
	char quote = 0;
	for (; m_at < m_text.size(); ++m_at)
	{
		const char c = m_text[m_at];
		if (quote) quote = c == quote ? char(0) : quote;
		else if (c == '"' || c == '\'') quote = c;
		else if (c == '>') break;
	}
	if (m_at == m_text.size()) return false;
	m_tag = m_text.substr(first, m_at++ - first);
	m_closed = m_tag.ends_with('/');
	if (m_closed) m_tag.remove_suffix(1);
	++m_depth;
	return true;
}

bool XmlTags::next()
{
	if (std::exchange(m_closed, false)) --m_depth;
	for (;;)
	{
		if (!skipTo("<")) return false;
		const std::string_view rest = m_text.substr(m_at);
		bool whole = true;
		if (rest.starts_with('?')) whole = skipTo("?>");
		else if (rest.starts_with("!--")) whole = skipTo("-->");
		else if (rest.starts_with("![CDATA[")) whole = skipTo("]]>");
		else if (rest.starts_with('!')) whole = skipDeclaration();
		else if (rest.starts_with('/')) whole = skipTo(">"), --m_depth;
		else return takeStartTag();
		if (!whole) return false;
	}
}

std::string_view XmlTags::name() const
{
	const std::string_view whole = m_tag.substr(0, m_tag.find_first_of(kBlanks));
	const size_t colon = whole.find(':');
	return colon == whole.npos ? whole : whole.substr(colon + 1);
}

template <class Matches> std::optional<std::string> XmlTags::find(const Matches& matches) const
{
	for (size_t at = m_tag.find_first_of(kBlanks); at < m_tag.size();)
	{
		const size_t first = m_tag.find_first_not_of(kBlanks, at), equals = m_tag.find('=', first);
		if (first == m_tag.npos || equals == m_tag.npos) return std::nullopt;
		const size_t open = m_tag.find_first_of("\"'", equals);
		if (open == m_tag.npos) return std::nullopt;
		const size_t close = m_tag.find(m_tag[open], open + 1);
		if (close == m_tag.npos) return std::nullopt;
		const std::string_view found = m_tag.substr(first, equals - first);
		if (matches(found.substr(0, found.find_last_not_of(kBlanks) + 1))) return withoutEntities(m_tag.substr(open + 1, close - open - 1));
		at = close + 1;
	}
	return std::nullopt;
}

std::optional<std::string> XmlTags::attribute(std::string_view name) const
{
	return find([&](std::string_view found) { return found == name; });
}

std::optional<std::string> XmlTags::prefixedAttribute(std::string_view name) const
{
	return find([&](std::string_view found) {
		const size_t colon = found.find(':');
		return colon != found.npos && found.substr(colon + 1) == name;
	});
}
}  // namespace ist
