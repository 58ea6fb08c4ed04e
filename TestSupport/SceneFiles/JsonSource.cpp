// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/JsonSource.h"

#include "BulletISTCollision/Core/Platform/Utf8Path.h"
#include "BulletISTCollision/Json/EditDistance.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>
#include <utility>

using ist::Error;
using ist::Vec3;
using Json = ist::JsonValue;

namespace scenes
{
namespace
{
constexpr int kDeepest = 32;
constexpr size_t kLongestPath = 200;  // of a path that is replaced, which bounds how deep it leads

/// Walks over text that is known to be JSON, and records the line of every value.
class Places
{
public:
	/// Skips a byte order mark, as the parser does.
	explicit Places(const std::string& text) : m_text(text), m_at(text.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0) {}

	void value(const std::string& path, int depth)
	{
		skip();
		lines[path] = m_line;
		if (depth > kDeepest) problem = "is nested too deeply", problemAt = path;
		if (!problem.empty()) return;
		if (m_text[m_at] == '{') object(path, depth);
		else if (m_text[m_at] == '[') array(path, depth);
		else if (m_text[m_at] == '"') string();
		else
			while (m_at < m_text.size() && std::string(",]} \t\r\n").find(m_text[m_at]) == std::string::npos) ++m_at;
	}

	std::map<std::string, int> lines;
	std::string problem, problemAt;

private:
	void skip()
	{
		for (; m_at < m_text.size() && std::string(" \t\r\n").find(m_text[m_at]) != std::string::npos; ++m_at)
			m_line += m_text[m_at] == '\n';
	}

	std::string string()
	{
		const size_t begin = m_at++;
		for (; m_text[m_at] != '"'; ++m_at) m_at += m_text[m_at] == '\\';
		++m_at;
		return ist::parseJson(m_text.substr(begin, m_at - begin)).value.text();
	}

	/// Moves behind the bracket or the comma. Returns false after the last member.
	bool next(char end)
	{
		++m_at;
		skip();
		if (m_text[m_at] != end) return true;
		++m_at;
		return false;
	}

	void object(const std::string& path, int depth)
	{
		if (!next('}')) return;
		for (;;)
		{
			skip();
			const int line = m_line;
			const std::string name = string(), full = path.empty() ? name : path + "." + name;
			skip();
			++m_at;
			if (lines.count(full) && problem.empty()) problem = "stands there twice", problemAt = full;
			value(full, depth + 1);
			lines[full] = line;
			if (!problem.empty()) return;
			skip();
			if (m_text[m_at] != ',') break;
			++m_at;
		}
		++m_at;
	}

	void array(const std::string& path, int depth)
	{
		if (!next(']')) return;
		for (int i = 0;; ++i)
		{
			value(path + "[" + std::to_string(i) + "]", depth + 1);
			if (!problem.empty()) return;
			skip();
			if (m_text[m_at] != ',') break;
			++m_at;
		}
		++m_at;
	}

	const std::string& m_text;
	size_t m_at;
	int m_line = 1;
};

/// A copy of `from` in which the value at `rest`, the remainder of a path, is `value`. `why` says what is wrong with the path.
Json replaced(const Json& from, std::string rest, Json value, std::string& why)
{
	if (rest.empty()) return value;
	if (rest[0] != '[')
	{
		rest.erase(0, rest[0] == '.' ? 1 : 0);
		const size_t end = std::min(rest.find_first_of(".["), rest.size());
		const std::string name = rest.substr(0, end);
		if (name.empty()) why = "is no path such as bodies[0].asset";
		else if (!from.isObject() && !from.isNull()) why = "is a field of what is no object";
		if (!why.empty()) return from;
		Json copy = from.isNull() ? Json::object() : from;
		copy[name] = replaced(from[name], rest.substr(end), std::move(value), why);
		return copy;
	}
	const size_t end = rest.find(']');
	const std::string digits = end == std::string::npos ? "" : rest.substr(1, end - 1);
	const bool whole = !digits.empty() && digits.size() < 9 && digits.find_first_not_of("0123456789") == std::string::npos;
	if (!whole) why = "is no path such as bodies[0].asset";
	else if (!from.isList() || std::stoul(digits) >= from.size()) why = "is an element that is not there";
	if (!why.empty()) return from;
	Json copy = Json::list();
	for (size_t i = 0; i < from.size(); ++i)
		copy.append(i == std::stoul(digits) ? replaced(from[i], rest.substr(end + 1), std::move(value), why) : from[i]);
	return copy;
}
}  // namespace

ist::Result<JsonSource> JsonSource::parse(const std::string& name, const std::string& text)
{
	ist::ParsedJson parsed = ist::parseJson(text);
	if (!parsed.ok()) return Error{name + ":" + std::to_string(parsed.line) + ": not JSON: " + parsed.problem};
	JsonSource source;
	source.m_name = name;
	source.m_root = std::move(parsed.value);
	Places places(text);
	places.value("", 0);
	source.m_lines = std::move(places.lines);
	if (!places.problem.empty()) return source.problem(places.problemAt, places.problem);
	return source;
}

ist::Result<JsonSource> JsonSource::load(const std::string& path)
{
	const Error unreadable{path + ": cannot be read"};
	std::error_code failed;
	if (!std::filesystem::is_regular_file(ist::systemPath(path), failed)) return unreadable;
	std::ifstream file(ist::systemPath(path), std::ios::binary);
	std::ostringstream text;
	if (!file.is_open() || (file.peek() != std::ifstream::traits_type::eof() && !(text << file.rdbuf())) || file.bad()) return unreadable;
	return parse(path, text.str());
}

std::optional<Error> JsonSource::replace(const std::string& path, Json value)
{
	std::string why;
	if (path.empty() || path.size() > kLongestPath) why = "is no path such as bodies[0].asset";
	Json root = why.empty() ? replaced(m_root, path, std::move(value), why) : Json();
	if (!why.empty()) return Error{"\"" + path + "\" " + why};
	m_root = std::move(root);
	for (auto line = m_lines.lower_bound(path + "."); line != m_lines.end() && line->first.compare(0, path.size(), path) == 0;)
	{
		const char next = line->first[path.size()];
		line = next == '.' || next == '[' ? m_lines.erase(line) : std::next(line);
	}
	return std::nullopt;
}

Error JsonSource::problem(const std::string& path, const std::string& problem) const
{
	std::string at = path;
	while (!m_lines.count(at))
	{
		const size_t end = at.find_last_of(".[");
		at = end == std::string::npos ? "" : at.substr(0, end);
	}
	return Error{m_name + ":" + std::to_string(m_lines.at(at)) + ": " + (path.empty() ? "" : path + ": ") + problem};
}

JsonFields::JsonFields(const JsonSource& source, const Json& object, std::string path, std::optional<Error>& problem)
	: m_source(source),
	  m_object(object),
	  m_path(std::move(path)),
	  m_problem(problem)
{
	if (!m_object.isObject()) refuse("", "wants an object in braces");
}

void JsonFields::refuse(const std::string& name, const std::string& problem)
{
	if (!m_problem) m_problem = m_source.problem(pathOf(name), problem);
}

const Json* JsonFields::find(const std::string& name)
{
	m_known.insert(name);
	if (m_problem) return nullptr;
	return m_object.find(name);
}

bool JsonFields::has(const std::string& name) { return find(name) != nullptr; }

void JsonFields::need(const std::string& name)
{
	if (m_problem || has(name)) return;
	for (const auto& [other, value] : m_object.fields())
		if (ist::editDistance(other, name) <= name.size() / 3) return refuse(other, "no such field is known here; is " + name + " meant?");
	refuse(name, "is missing");
}

double JsonFields::number(const std::string& name, double otherwise, double least, double most)
{
	const Json* value = find(name);
	if (!value) return otherwise;
	const auto shown = [](double v) { return Json(v).dump(); };
	const double found = value->isNumber() ? value->number() : std::nan("");
	if (found >= least && found <= most) return found;
	refuse(name, "wants a number from " + shown(least) + " to " + shown(most) + ", not " + value->dump());
	return otherwise;
}

int64_t JsonFields::whole(const std::string& name, int64_t otherwise, int64_t least, int64_t most)
{
	const double found = number(name, static_cast<double>(otherwise), static_cast<double>(least), static_cast<double>(most));
	if (found != std::floor(found)) refuse(name, "wants a whole number");
	return static_cast<int64_t>(found);
}

bool JsonFields::flag(const std::string& name, bool otherwise)
{
	const Json* value = find(name);
	if (!value) return otherwise;
	if (value->isFlag()) return value->flag();
	refuse(name, "wants true or false, not " + value->dump());
	return otherwise;
}

std::string JsonFields::text(const std::string& name, const std::string& otherwise)
{
	const Json* value = find(name);
	if (!value) return otherwise;
	if (!value->text().empty()) return value->text();
	refuse(name, "wants a text in quotes, not " + value->dump());
	return otherwise;
}

int JsonFields::choice(const std::string& name, int otherwise, const std::vector<std::string>& known)
{
	const std::string found = text(name);
	if (found.empty()) return otherwise;
	const auto at = std::find(known.begin(), known.end(), found);
	if (at != known.end()) return static_cast<int>(at - known.begin());
	std::string all;
	for (const std::string& k : known) all += (all.empty() ? "" : ", ") + k;
	refuse(name, "wants one of " + all + ", not " + found);
	return otherwise;
}

Vec3 JsonFields::vector(const std::string& name, const Vec3& otherwise, double largest)
{
	const Json* value = find(name);
	if (!value) return otherwise;
	Vec3 found;
	bool good = value->isList() && value->size() == 3;
	for (int i = 0; good && i < 3; ++i)
	{
		const Json& entry = (*value)[i];
		good = entry.isNumber() && std::fabs(entry.number()) <= largest;
		if (good) found[i] = entry.number();
	}
	if (good) return found;
	refuse(name, "wants three numbers of at most " + Json(largest).dump() + " in size, not " + value->dump());
	return otherwise;
}

const Json* JsonFields::list(const std::string& name)
{
	const Json* value = find(name);
	if (!value || value->isList()) return value;
	refuse(name, "wants a list in brackets");
	return nullptr;
}

const Json* JsonFields::object(const std::string& name)
{
	const Json* value = find(name);
	if (!value || value->isObject()) return value;
	refuse(name, "wants an object in braces");
	return nullptr;
}

void JsonFields::finish()
{
	if (m_problem) return;
	for (const auto& [name, value] : m_object.fields())
	{
		if (m_known.count(name)) continue;
		std::string all;
		for (const std::string& k : m_known) all += (all.empty() ? "" : ", ") + k;
		refuse(name, "no such field is known here; known ones are " + all);
		return;
	}
}
}  // namespace scenes
