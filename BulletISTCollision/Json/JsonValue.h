// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace ist
{
/// A value of JSON. JsonValue.cpp is the only source that includes the JSON library, because that takes seconds to compile.
/// An object keeps its fields in the order in which they were added.
class JsonValue
{
public:
	struct Field;
	enum class Kind
	{
		Null,
		Flag,
		Whole,     ///< int64_t
		Unsigned,  ///< uint64_t
		Real,
		Text,
		List,
		Object
	};

	JsonValue();
	JsonValue(std::nullptr_t);
	template <class T, std::enable_if_t<std::is_arithmetic_v<T>, int> = 0> JsonValue(T value)
	{
		if constexpr (std::is_same_v<T, bool>) m_kind = Kind::Flag, m_whole = value;
		else if constexpr (std::is_floating_point_v<T>) m_kind = Kind::Real, m_real = value;
		else m_kind = std::is_signed_v<T> ? Kind::Whole : Kind::Unsigned, m_whole = static_cast<int64_t>(value);
	}
	JsonValue(const char* text);
	JsonValue(std::string text);
	JsonValue(std::string_view text);
	/// A list of the elements of a container.
	template <class Range, class = decltype(std::declval<const Range&>().begin()),
		std::enable_if_t<!std::is_convertible_v<const Range&, std::string_view> && !std::is_same_v<Range, JsonValue>, int> = 0>
	JsonValue(const Range& range) : m_kind(Kind::List)
	{
		for (const auto& item : range) m_items.emplace_back(item);
	}
	/// An object if every element is a pair that begins with a text, else a list.
	JsonValue(std::initializer_list<JsonValue> items);
	/// A list, whatever its elements are.
	static JsonValue list(std::initializer_list<JsonValue> items = {});
	static JsonValue object();
	JsonValue(const JsonValue&);
	JsonValue(JsonValue&&) noexcept;
	JsonValue& operator=(const JsonValue&);
	JsonValue& operator=(JsonValue&&) noexcept;
	~JsonValue();

	Kind kind() const { return m_kind; }
	bool isNull() const { return m_kind == Kind::Null; }
	bool isFlag() const { return m_kind == Kind::Flag; }
	bool isNumber() const { return m_kind == Kind::Whole || m_kind == Kind::Unsigned || m_kind == Kind::Real; }
	bool isText() const { return m_kind == Kind::Text; }
	bool isList() const { return m_kind == Kind::List; }
	bool isObject() const { return m_kind == Kind::Object; }

	/// False for everything but `true`.
	bool flag() const { return isFlag() && m_whole != 0; }
	/// The bits of a whole number; zero for what is no whole number.
	int64_t whole() const { return m_whole; }
	/// Zero for everything but a number.
	double number() const;
	/// Empty for everything but a text.
	const std::string& text() const { return m_text; }
	/// Number of elements or fields.
	std::size_t size() const;
	bool empty() const { return size() == 0; }

	/// The elements of a list.
	const std::vector<JsonValue>& items() const { return m_items; }
	std::vector<JsonValue>::const_iterator begin() const { return m_items.begin(); }
	std::vector<JsonValue>::const_iterator end() const { return m_items.end(); }
	const std::vector<Field>& fields() const { return m_fields; }
	/// Null where this is no object, or has no such field.
	const JsonValue* find(std::string_view name) const;
	bool contains(std::string_view name) const { return find(name) != nullptr; }
	/// The null value where there is no such element or field.
	const JsonValue& operator[](std::string_view name) const;
	const JsonValue& operator[](const char* name) const { return (*this)[std::string_view(name)]; }
	template <class Index, std::enable_if_t<std::is_integral_v<Index>, int> = 0> const JsonValue& operator[](Index i) const
	{
		return item(static_cast<std::size_t>(i));
	}

	/// Adds the field where it is missing. What is no object becomes an empty one.
	JsonValue& operator[](std::string_view name);
	JsonValue& operator[](const char* name) { return (*this)[std::string_view(name)]; }
	/// Adds an element. What is no list becomes an empty one.
	JsonValue& append(JsonValue value);
	JsonValue& append();

	/// Numbers are equal by their value.
	friend bool operator==(const JsonValue& a, const JsonValue& b) { return a.equals(b); }

	/// JSON on one line, or with one tab for each level. Bytes that are no UTF-8 are replaced, and a number that is not finite is null.
	std::string dump(bool indented = false) const;

private:
	bool equals(const JsonValue& other) const;
	const JsonValue& item(std::size_t i) const;

	Kind m_kind = Kind::Null;
	int64_t m_whole = 0;
	double m_real = 0;
	std::string m_text;
	std::vector<JsonValue> m_items;
	std::vector<Field> m_fields;
};

struct JsonValue::Field
{
	std::string name;
	JsonValue value;
};

inline std::size_t JsonValue::size() const { return isObject() ? m_fields.size() : m_items.size(); }

/// What parseJson made of a text.
struct ParsedJson
{
	JsonValue value;
	std::string problem;   ///< why the text is no JSON; empty where it is
	int line = 1;          ///< line of the problem
	std::string repeated;  ///< first field of the outermost object that the text has twice; the last one counts

	bool ok() const { return problem.empty(); }
};
/// Refuses what nests deeper than 1,000.
ParsedJson parseJson(const std::string& text);
/// Number of the line that holds the byte `offset`, from 1.
int lineAt(std::string_view text, std::size_t offset);
}  // namespace ist
