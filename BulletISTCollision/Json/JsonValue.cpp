// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Json/JsonValue.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

namespace ist
{
namespace
{
using Json = nlohmann::ordered_json;
constexpr std::size_t kDeepest = 1000;  // a tree of values is copied and destroyed by recursion

const JsonValue kNone;

Json toLibrary(const JsonValue& value)
{
	switch (value.kind())
	{
	case JsonValue::Kind::Null: return nullptr;
	case JsonValue::Kind::Flag: return value.flag();
	case JsonValue::Kind::Whole: return value.whole();
	case JsonValue::Kind::Unsigned: return static_cast<uint64_t>(value.whole());
	case JsonValue::Kind::Real: return value.number();
	case JsonValue::Kind::Text: return value.text();
	case JsonValue::Kind::List: break;
	case JsonValue::Kind::Object: break;
	}
	Json json = value.isList() ? Json::array() : Json::object();
	for (const JsonValue& item : value) json.push_back(toLibrary(item));
	for (const auto& [name, field] : value.fields()) json[name] = toLibrary(field);
	return json;
}

/// Offset of what the parser stumbled over. A number that is too large comes without its place but with its text in quotes.
std::size_t placeOf(const Json::exception& e, const std::string& text)
{
	// The identifiers of the library's parse errors; a dynamic_cast needs RTTI.
	if (e.id > 100 && e.id < 200)
	{
		const std::size_t read = static_cast<const Json::parse_error&>(e).byte;
		return read > 0 ? read - 1 : 0;
	}
	const std::string message = e.what();
	const std::size_t first = message.find('\''), last = message.rfind('\'');
	if (first == std::string::npos || last <= first) return 0;
	const std::size_t at = text.find(message.substr(first + 1, last - first - 1));
	return at == std::string::npos ? 0 : at;
}

/// The parser's own words without its number.
std::string complaintOf(const Json::exception& e)
{
	const std::string message = e.what();
	const std::size_t end = message.find("] ");
	return end == std::string::npos ? message : message.substr(end + 2);
}

/// Builds values from the events of the library's parser, whose interface asks for these names.
class ValueBuilder final : public nlohmann::json_sax<Json>
{
public:
	ValueBuilder(const std::string& text, ParsedJson& out) : m_text(text), m_out(out) {}

	bool null() override { return add({}); }
	bool boolean(bool value) override { return add(value); }
	bool number_integer(number_integer_t value) override { return add(value); }
	bool number_unsigned(number_unsigned_t value) override { return add(value); }
	bool number_float(number_float_t value, const string_t&) override { return add(value); }
	bool string(string_t& value) override { return add(std::move(value)); }
	bool binary(binary_t&) override { return false; }
	bool start_object(std::size_t) override { return open(JsonValue::object()); }
	bool end_object() override { return close(); }
	bool start_array(std::size_t) override { return open(JsonValue::list()); }
	bool end_array() override { return close(); }

	bool key(string_t& name) override
	{
		if (m_open.size() == 1 && m_out.repeated.empty() && m_open.back()->contains(name)) m_out.repeated = name;
		m_field = &(*m_open.back())[name];
		return true;
	}

	bool parse_error(std::size_t, const std::string&, const Json::exception& e) override
	{
		m_out.problem = complaintOf(e);
		m_out.line = lineAt(m_text, placeOf(e, m_text));
		return false;
	}

private:
	/// Where the next value belongs.
	JsonValue& place()
	{
		if (m_open.empty()) return m_out.value;
		return m_open.back()->isList() ? m_open.back()->append() : *m_field;
	}

	bool add(JsonValue value)
	{
		place() = std::move(value);
		return true;
	}

	bool open(JsonValue value)
	{
		if (m_open.size() == kDeepest)
		{
			m_out.problem = "it nests deeper than " + std::to_string(kDeepest);
			return false;
		}
		JsonValue& opened = place();
		opened = std::move(value);
		m_open.push_back(&opened);
		return true;
	}

	bool close()
	{
		m_open.pop_back();
		return true;
	}

	const std::string& m_text;
	ParsedJson& m_out;
	// No element is appended to a list while one of its elements is open, so these stay valid.
	std::vector<JsonValue*> m_open;
	JsonValue* m_field = nullptr;
};
}  // namespace

JsonValue::JsonValue() = default;
JsonValue::JsonValue(std::nullptr_t) {}
JsonValue::JsonValue(const char* text) : m_kind(Kind::Text), m_text(text) {}
JsonValue::JsonValue(std::string text) : m_kind(Kind::Text), m_text(std::move(text)) {}
JsonValue::JsonValue(std::string_view text) : m_kind(Kind::Text), m_text(text) {}
JsonValue::JsonValue(const JsonValue&) = default;
JsonValue::JsonValue(JsonValue&&) noexcept = default;
JsonValue& JsonValue::operator=(const JsonValue&) = default;
JsonValue& JsonValue::operator=(JsonValue&&) noexcept = default;
JsonValue::~JsonValue() = default;

JsonValue::JsonValue(std::initializer_list<JsonValue> items) : JsonValue(list(items))
{
	const auto isField = [](const JsonValue& item) { return item.isList() && item.size() == 2 && item[0].isText(); };
	if (!std::all_of(items.begin(), items.end(), isField)) return;
	m_kind = Kind::Object;
	for (JsonValue& item : m_items) m_fields.push_back({std::move(item.m_items[0].m_text), std::move(item.m_items[1])});
	m_items.clear();
}

JsonValue JsonValue::list(std::initializer_list<JsonValue> items)
{
	JsonValue value;
	value.m_kind = Kind::List;
	value.m_items = items;
	return value;
}

JsonValue JsonValue::object()
{
	JsonValue value;
	value.m_kind = Kind::Object;
	return value;
}

double JsonValue::number() const
{
	switch (m_kind)
	{
	case Kind::Whole: return static_cast<double>(m_whole);
	case Kind::Unsigned: return static_cast<double>(static_cast<uint64_t>(m_whole));
	case Kind::Real: return m_real;
	default: return 0;
	}
}

const JsonValue* JsonValue::find(std::string_view name) const
{
	const auto found = std::find_if(m_fields.begin(), m_fields.end(), [&](const Field& field) { return field.name == name; });
	return found == m_fields.end() ? nullptr : &found->value;
}

const JsonValue& JsonValue::operator[](std::string_view name) const
{
	const JsonValue* found = find(name);
	return found ? *found : kNone;
}

const JsonValue& JsonValue::item(std::size_t i) const { return i < m_items.size() ? m_items[i] : kNone; }

JsonValue& JsonValue::operator[](std::string_view name)
{
	if (!isObject()) *this = object();
	if (const JsonValue* found = find(name)) return const_cast<JsonValue&>(*found);
	return m_fields.emplace_back(Field{std::string(name), {}}).value;
}

JsonValue& JsonValue::append(JsonValue value)
{
	if (!isList()) *this = list();
	return m_items.emplace_back(std::move(value));
}

JsonValue& JsonValue::append() { return append(JsonValue()); }

bool JsonValue::equals(const JsonValue& other) const
{
	if (isNumber() && other.isNumber()) return number() == other.number();
	const auto sameField = [](const Field& a, const Field& b) { return a.name == b.name && a.value == b.value; };
	return m_kind == other.m_kind && m_whole == other.m_whole && m_text == other.m_text && m_items == other.m_items &&
		std::equal(m_fields.begin(), m_fields.end(), other.m_fields.begin(), other.m_fields.end(), sameField);
}

std::string JsonValue::dump(bool indented) const
{
	return toLibrary(*this).dump(indented ? 1 : -1, indented ? '\t' : ' ', false, Json::error_handler_t::replace);
}

int lineAt(std::string_view text, std::size_t offset)
{
	return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text.size())), '\n'));
}

ParsedJson parseJson(const std::string& text)
{
	ParsedJson out;
	ValueBuilder builder(text, out);
	if (!Json::sax_parse(text, &builder) && out.problem.empty()) out.problem = "it cannot be read";
	if (!out.ok()) out.value = {};
	return out;
}
}  // namespace ist
