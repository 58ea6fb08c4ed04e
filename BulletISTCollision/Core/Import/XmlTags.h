// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// The start tags of an XML text in UTF-8, which must outlive it, one after the other. Comments, CDATA, declarations and text are passed
/// over. Damaged XML ends the walk: what reads the text afterwards is to refuse it.
class XmlTags
{
public:
	explicit XmlTags(std::string_view text) : m_text(text) {}

	/// Goes to the next start tag. False: there is none.
	bool next();
	/// Without the prefix of its name space.
	std::string_view name() const;
	/// 1: the root.
	int depth() const { return m_depth; }
	std::optional<std::string> attribute(std::string_view name) const;

private:
	bool skipTo(std::string_view end);
	bool skipDeclaration();
	bool takeStartTag();

	std::string_view m_text, m_tag;
	size_t m_at = 0;
	int m_depth = 0;
	bool m_closed = false;  // the tag ended with "/>"
};
}  // namespace ist
