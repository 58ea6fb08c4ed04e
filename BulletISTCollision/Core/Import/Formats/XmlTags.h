// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ist
{
/// Iterates over the start tags of an XML text in UTF-8, which must outlive this object. Comments, CDATA, declarations and text are
/// skipped. Damaged XML ends the iteration; the reader that reads the text afterwards must refuse it.
class XmlTags
{
public:
	explicit XmlTags(std::string_view text) : m_text(text) {}

	/// Goes to the next start tag; false if there is none.
	bool next();
	/// Name without its namespace prefix.
	std::string_view name() const;
	/// Depth of the tag; the root has 1.
	int depth() const { return m_depth; }
	/// The value of an attribute, by its name with the prefix.
	std::optional<std::string> attribute(std::string_view name) const;
	/// The value of the first attribute that has this name and a prefix.
	std::optional<std::string> prefixedAttribute(std::string_view name) const;
	/// Bytes of the text before the end of the tag.
	size_t position() const { return m_at; }
	/// After the last tag: whether each element was closed.
	bool isWhole() const { return m_depth == 0; }

private:
	bool skipTo(std::string_view end);
	bool skipDeclaration();
	bool takeStartTag();
	template <class Matches> std::optional<std::string> find(const Matches& matches) const;

	std::string_view m_text, m_tag;
	size_t m_at = 0;
	int m_depth = 0;
	bool m_closed = false;  // the tag ended with "/>"
};
}  // namespace ist
